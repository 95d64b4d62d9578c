#include "door_planner/blocked_cells.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace hymm::core {
namespace {

Eigen::Matrix2d cellEdges(const Triangle& triangle, const TriangularGrid& grid) {
  return triangle.edges() *
         Eigen::Vector2d(1.0 / grid.alphaCells(), 1.0 / grid.betaCells()).asDiagonal();
}

}  // namespace

BlockedCells::BlockedCells(const Triangle& triangle, const TriangularGrid& grid,
                           double half_width_m)
    : triangle_(triangle),
      grid_(grid),
      half_width_m_(half_width_m),
      cell_edges_(cellEdges(triangle, grid)),
      inverse_(cell_edges_.inverse()),
      blocked_(std::size_t(grid.cellCount()), false) {}

void BlockedCells::keepAwayFrom(const Triangle& triangle, const CellCosts& costs) {
  const Eigen::Matrix2d edges = cellEdges(triangle, costs.grid());
  const double half_diagonal =
      0.5 * std::max((edges.col(0) + edges.col(1)).norm(), (edges.col(0) - edges.col(1)).norm());
  for (const Eigen::Vector2f& obstacle : costs.obstacles()) {
    const Eigen::Vector2d place = triangle.toGlobal(obstacle.cast<double>());
    block(grid_.toCells(triangle_.toLocal(place)), half_width_m_ + half_diagonal);
  }
}

/// Cells with their centres within a radius of a place in units of cells.
void BlockedCells::block(const Eigen::Vector2d& centre, double radius_m) {
  const auto first = [](double at) { return std::max(0, static_cast<int>(std::ceil(at - 0.5))); };
  const auto last = [](double at, int count) {
    return std::min(count - 1, static_cast<int>(std::floor(at - 0.5)));
  };
  const Eigen::Vector2d box = radius_m * inverse_.rowwise().norm();
  const int j1 = last(centre.y() + box.y(), grid_.betaCells());
  for (int j = first(centre.y() - box.y()); j <= j1; ++j) {
    const int i1 = last(centre.x() + box.x(), grid_.rowLength(j));
    for (int i = first(centre.x() - box.x()); i <= i1; ++i) {
      const Eigen::Vector2d apart(i + 0.5 - centre.x(), j + 0.5 - centre.y());
      if ((cell_edges_ * apart).squaredNorm() < radius_m * radius_m) {
        blocked_[std::size_t(grid_.index(i, j))] = true;
      }
    }
  }
}

}  // namespace hymm::core
