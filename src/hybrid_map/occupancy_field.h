#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "hybrid_map/hybrid_map.h"

namespace hymm::core {

/// How far places around a point are from the nearest occupied cell of a map: what a scan is held
/// against. A copy of what the map knows in a square, in its own cells.
class OccupancyField {
 public:
  /// The square reaches `reach_m` to each side of `centre`.
  OccupancyField(const HybridMap& map, const Eigen::Vector2d& centre, double reach_m,
                 double resolution_m);

  double resolution_m() const { return resolution_m_; }

  /// Distances [m] of all cells from the nearest occupied cell's middle, at most farthest(); NaN
  /// where the map knows neither the place nor an obstacle near it.
  const std::vector<float>& distances() const { return distances_; }
  /// The cell of a place, or -1 beyond the square.
  int cellAt(const Eigen::Vector2d& place) const {
    const Eigen::Array2d cell = ((place - low_) / resolution_m_).array();
    if (!(cell >= 0.0).all() || !(cell < edge_).all()) return -1;
    return static_cast<int>(cell.y()) * edge_ + static_cast<int>(cell.x());
  }
  bool knows(const Eigen::Vector2d& place) const {
    const int cell = cellAt(place);
    return cell >= 0 && !std::isnan(distances_[std::size_t(cell)]);
  }

  /// The distance, interpolated between cells; unknown places count as `farthest()`.
  double smoothDistance(const Eigen::Vector2d& place) const;

  double farthest() const { return kFarthestCells * resolution_m_; }
  bool hasObstacles() const { return has_obstacles_; }

 private:
  static constexpr int kFarthestCells = 3;

  void stamp(int x, int y);
  float at(int x, int y) const;

  double resolution_m_;
  Eigen::Vector2d low_;
  int edge_;  ///< cells along a side
  bool has_obstacles_ = false;
  std::vector<float> distances_;  ///< NaN: unknown
};

}  // namespace hymm::core
