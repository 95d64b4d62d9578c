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

double halfDiagonal(const Eigen::Matrix2d& edges) {
  return 0.5 * std::max((edges.col(0) + edges.col(1)).norm(), (edges.col(0) - edges.col(1)).norm());
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
  const double half_diagonal = halfDiagonal(cellEdges(triangle, costs.grid()));
  for (const Eigen::Vector2f& obstacle : costs.obstacles()) {
    const Eigen::Vector2d place = triangle.toGlobal(obstacle.cast<double>());
    const Eigen::Vector2d centre = grid_.toCells(triangle_.toLocal(place));
    block(centre, centre, half_width_m_ + half_diagonal);
  }
}

// The vehicle may be anywhere in a cell that is passable, so that half of the cell is kept as well.
void BlockedCells::keepAwayFrom(const Barrier& barrier, double slack_m) {
  const auto toCells = [this](const Eigen::Vector2d& place) {
    return grid_.toCells(triangle_.toLocal(place));
  };
  block(toCells(barrier.from), toCells(barrier.to),
        half_width_m_ + barrier.radius_m + slack_m + halfDiagonal(cell_edges_));
}

/// Cells with their centres within a radius of a stretch in units of cells.
void BlockedCells::block(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double radius_m) {
  const auto first = [](double at) { return std::max(0, static_cast<int>(std::ceil(at - 0.5))); };
  const auto last = [](double at, int count) {
    return std::min(count - 1, static_cast<int>(std::floor(at - 0.5)));
  };
  const Eigen::Vector2d box = radius_m * inverse_.rowwise().norm();
  const Eigen::Vector2d low = from.cwiseMin(to) - box, high = from.cwiseMax(to) + box;
  const Eigen::Vector2d along_m = cell_edges_ * (to - from);
  const double length2 = along_m.squaredNorm();
  const int j1 = last(high.y(), grid_.betaCells());
  for (int j = first(low.y()); j <= j1; ++j) {
    const int i1 = last(high.x(), grid_.rowLength(j));
    for (int i = first(low.x()); i <= i1; ++i) {
      const Eigen::Vector2d apart_m = cell_edges_ * (Eigen::Vector2d(i + 0.5, j + 0.5) - from);
      const double at = length2 > 0.0 ? std::clamp(apart_m.dot(along_m) / length2, 0.0, 1.0) : 0.0;
      if ((apart_m - at * along_m).squaredNorm() < radius_m * radius_m) {
        blocked_[std::size_t(grid_.index(i, j))] = true;
      }
    }
  }
}

}  // namespace hymm::core
