#pragma once

#include <functional>
#include <limits>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "common/random.h"
#include "door_planner/cell_costs.h"
#include "door_planner/ltr_view.h"

namespace hymm::test {

/// Places of landmarks by id.
using Landmarks = std::vector<Eigen::Vector2d>;

/// A mesh over the landmarks of a square grid, two LTRs a square; ids count rows from the origin.
struct SquareMesh {
  Landmarks landmarks;
  std::vector<core::LtrView> ltrs;

  /// `edge_m` between landmarks, which are moved at random by up to `jitter_m`.
  SquareMesh(int columns, int rows, double edge_m, double resolution_m, double jitter_m = 0.0,
             std::uint64_t seed = 1) {
    core::RandomGenerator generator(seed);
    for (int row = 0; row <= rows; ++row) {
      for (int column = 0; column <= columns; ++column) {
        const auto shift = [&] { return core::sampleUniform(generator, -jitter_m, jitter_m); };
        const double x = column * edge_m + (jitter_m > 0.0 ? shift() : 0.0);
        landmarks.emplace_back(x, row * edge_m + (jitter_m > 0.0 ? shift() : 0.0));
      }
    }
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) addSquare(column, row, columns, rows);
    }
    moveTo(landmarks);
    for (core::LtrView& ltr : ltrs) {
      const auto cells = [&](std::size_t to) {
        return static_cast<int>(
            std::ceil((ltr.corners[to] - ltr.corners[0]).norm() / resolution_m));
      };
      ltr.alpha_cells = cells(1);
      ltr.beta_cells = cells(2);
    }
  }

  void moveTo(const Landmarks& places) {
    landmarks = places;
    for (core::LtrView& ltr : ltrs) {
      for (std::size_t k = 0; k < 3; ++k) {
        ltr.corners[k] = landmarks[std::size_t(ltr.landmark_ids[k])];
      }
    }
  }

 private:
  /// The lower left half is LTR 2 s, the upper right half 2 s + 1 of square s.
  void addSquare(int column, int row, int columns, int rows) {
    const auto id = [&](int c, int r) { return r * (columns + 1) + c; };
    const auto square = [&](int c, int r) {
      return c < 0 || r < 0 || c >= columns || r >= rows ? -1 : r * columns + c;
    };
    const auto half = [](int of, int upper) { return of < 0 ? core::kNone : 2 * of + upper; };
    const int here = square(column, row);
    core::LtrView lower, upper;
    lower.id = 2 * here;
    lower.landmark_ids = {id(column, row), id(column + 1, row), id(column, row + 1)};
    lower.neighbours = {half(square(column, row - 1), 1), 2 * here + 1,
                        half(square(column - 1, row), 1)};
    upper.id = 2 * here + 1;
    upper.landmark_ids = {id(column + 1, row + 1), id(column, row + 1), id(column + 1, row)};
    upper.neighbours = {half(square(column, row + 1), 0), 2 * here,
                        half(square(column + 1, row), 0)};
    ltrs.push_back(lower);
    ltrs.push_back(upper);
  }
};

/// Occupancy of each cell by the place of its centre in map; NaN for unknown.
inline core::LtrContent contentOf(const core::LtrView& ltr,
                                  const std::function<float(const Eigen::Vector2d&)>& occupancy) {
  const core::TriangularGrid grid = core::gridOf(ltr.alpha_cells, ltr.beta_cells);
  const core::Triangle triangle(ltr.corners);
  core::LtrContent content;
  for (int j = 0; j < grid.betaCells(); ++j) {
    for (int i = 0; i < grid.rowLength(j); ++i) {
      content.occupancy.push_back(occupancy(
          triangle.toGlobal({(i + 0.5) / grid.alphaCells(), (j + 0.5) / grid.betaCells()})));
    }
  }
  return content;
}

}  // namespace hymm::test
