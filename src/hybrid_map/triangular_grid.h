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
    const CellWalk walk(toCellsInside(from), toCellsInside(to));
    // Both are read before one is written: where they are the same, it changes once.
    const auto changeBoth = [&](float& one, float& other) {
      const float changed = change(one), other_changed = change(other);
      one = changed;
      other = other_changed;
    };
    // A cell's index is its place i in the row and where row j starts.
    const int* rows = row_starts_.data() + walk.start_j;
    float* first = cells + walk.start_i;
    if (walk.is_along_i) {
      return walk.run(
          [&](int i, int j, int other) { changeBoth(first[rows[j] + i], first[rows[other] + i]); });
    }
    return walk.run([&](int j, int i, int other) {
      float* row = first + rows[j];
      changeBoth(row[i], row[other]);
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

  /// Place in units of cells, moved off the third side by less than matters. Every cell that
  /// touches a line between such places, even one that rounding takes for its neighbour, has its
  /// least corner inside the triangle, so it is one of the grid's.
  Triangle::Local toCellsInside(const Triangle::Local& local) const {
    // Some times what CellWalk rounds on its way through all columns or rows.
    const double most = 1.0 - 1e-10 * (alpha_cells_ + beta_cells_);
    const Triangle::Local inside = local.cwiseMax(0.0);
    const double beyond = std::max(0.0, inside.sum() - most);
    return toCells((inside.array() - beyond).max(0.0).matrix());
  }

  int alpha_cells_, beta_cells_;
  std::vector<int> row_starts_;  ///< and the end
};

}  // namespace hymm::core
