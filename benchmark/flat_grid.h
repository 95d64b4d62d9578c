#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/pose2.h"
#include "hybrid_map/hybrid_map_config.h"
#include "hybrid_map/occupancy_image.h"
#include "perception/laser_scan.h"

namespace hymm::benchmarks {

/// The peer of the hybrid map: log-odds in one array of square cells over the whole world, fixed to
/// the map's axes. What a correction moves has to be rasterised anew.
class FlatGrid {
 public:
  FlatGrid(const Eigen::Vector2d& low, const Eigen::Vector2d& high, double resolution_m,
           const core::OccupancyConfig& config);

  /// Writes a scan by the same rules as the hybrid map. Returns the number of beams.
  std::size_t insert(const core::LaserScan& scan, const core::Pose2& T_map_laser);
  void clear();

  core::OccupancyImage image() const;

 private:
  void writeBeam(const Eigen::Vector2d& from, const Eigen::Vector2d& to, bool hits);

  core::OccupancyConfig config_;
  Eigen::Vector2d low_;  ///< a whole number of cells from the origin
  double cells_per_m_;
  int width_, height_;
  float hit_, miss_, least_, most_;
  std::vector<float> cells_;
};

}  // namespace hymm::benchmarks
