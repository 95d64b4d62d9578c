#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "hybrid_map/cell_traversal.h"
#include "hybrid_map/simplex.h"

namespace hymm::core {

/// Cells of an LTR: a grid in (alpha, beta), of which only cells are kept that the triangle
/// touches. Row j holds the cells with beta between j / betaCells() and (j + 1) / betaCells(). When
/// the LTR is made a cell's sides are at most `resolution` long; later they stretch with it.
class TriangularGrid {
 public:
  TriangularGrid(const Triangle& triangle, double resolution_m)
      : TriangularGrid(cellsAlong(triangle.edges().col(0).norm(), resolution_m),
                       cellsAlong(triangle.edges().col(1).norm(), resolution_m)) {}

  /// Of so many cells along the two sides, at least one each.
  TriangularGrid(int alpha_cells, int beta_cells)
      : alpha_cells_(alpha_cells), beta_cells_(beta_cells) {
    row_starts_.reserve(std::size_t(beta_cells_) + 1);
    int start = 0;
    for (int j = 0; j < beta_cells_; ++j) {
      row_starts_.push_back(start);
      // Cells whose least corner lies inside: i / alpha_cells + j / beta_cells < 1.
      const long long inside = 1LL * alpha_cells_ * (beta_cells_ - j);
      start += static_cast<int>((inside + beta_cells_ - 1) / beta_cells_);
    }
    row_starts_.push_back(start);
  }

  int alphaCells() const { return alpha_cells_; }
  int betaCells() const { return beta_cells_; }
  int cellCount() const { return row_starts_.back(); }
  int rowLength(int j) const {
    return row_starts_[std::size_t(j) + 1] - row_starts_[std::size_t(j)];
  }

  /// Place in units of cells.
  Triangle::Local toCells(const Triangle::Local& local) const {
    return {local.x() * alpha_cells_, local.y() * beta_cells_};
  }

  /// Replaces each of `cells`, which belong to this grid, that the straight line between two places
  /// in the triangle passes by `change` of it. Returns how many. Exact but for rounding.
  template <class Change>
  int changeAlong(const Triangle::Local& from, const Triangle::Local& to, float* cells,
                  Change&& change) const {
    CellWalk walk(toCellsInside(from), toCellsInside(to));
    // Carried along, which is twice as fast as an index made of row and column.
    float* cell = cells + row_starts_[std::size_t(walk.j)] + walk.i;
    const int* start = row_starts_.data() + walk.j;
    const int upwards = walk.step_j > 0 ? 0 : 1;
    return walk.run([&] { *cell = change(*cell); }, [&] { cell += walk.step_i; },
                    [&] {
                      start += walk.step_j;
                      cell += walk.step_j * (start[upwards] - start[upwards - 1]);
                    });
  }

  /// The cell (i, j), or the nearest one in the grid.
  int index(int i, int j) const {
    const int row = std::clamp(j, 0, beta_cells_ - 1);
    return row_starts_[std::size_t(row)] + std::clamp(i, 0, rowLength(row) - 1);
  }
  int index(const Triangle::Local& local) const {
    const Triangle::Local cells = toCells(local);
    return index(static_cast<int>(std::floor(cells.x())), static_cast<int>(std::floor(cells.y())));
  }

 private:
  static int cellsAlong(double side_m, double resolution_m) {
    return std::max(1, static_cast<int>(std::ceil(side_m / resolution_m)));
  }

  /// Place in units of cells, moved off the upper borders by less than matters. Every cell that
  /// touches a line between such places, even one that rounding takes for its neighbour, has its
  /// least corner inside the triangle, so it is one of the grid's.
  Triangle::Local toCellsInside(const Triangle::Local& local) const {
    constexpr double kBelowOne = 1.0 - 1e-11;
    Triangle::Local inside = local.cwiseMax(0.0);
    const double sum = inside.sum();
    if (sum > kBelowOne) inside *= kBelowOne / sum;
    return toCells(inside);
  }

  int alpha_cells_, beta_cells_;
  std::vector<int> row_starts_;  ///< and the end
};

}  // namespace hymm::core
