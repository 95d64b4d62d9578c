#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace hymm::core {

/// Occupancy in square cells along map's axes, as nav_msgs/OccupancyGrid has it: 0 (free) to 100
/// (occupied) percent, -1 where nothing is known; row by row along x, from the corner of least x
/// and y.
struct OccupancyImage {
  static constexpr std::int8_t kUnknown = -1;

  double resolution_m = 0.0;
  /// Least corner in units of cells from map's origin: images of one resolution share their cells.
  Eigen::Vector2i corner = Eigen::Vector2i::Zero();
  int width = 0;   ///< cells along x
  int height = 0;  ///< cells along y
  std::vector<std::int8_t> cells;

  Eigen::Vector2d origin() const { return resolution_m * corner.cast<double>(); }  ///< m
  Eigen::Vector2d centre(int x, int y) const {
    return resolution_m * (corner.cast<double>() + Eigen::Vector2d(x + 0.5, y + 0.5));
  }
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
  std::int8_t at(int x, int y) const { return cells[index(x, y)]; }
};

/// Percent of a cell's log-odds (1), to the nearest; kUnknown for 0.
std::int8_t occupancyPercent(float log_odds);

}  // namespace hymm::core
