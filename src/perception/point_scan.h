#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/config.h"
#include "perception/laser_scan.h"

namespace hymm::core {

/// Which points of a 3D sensor's clouds count as obstacles, and in how many directions they are
/// sorted. Where the sensor stands, and how it is tilted, tf tells.
struct PointCloudConfig {
  double min_height_m = 0.3;  ///< above the ground's roughness
  double band_height_m = 1.7;
  double min_range_m = 0.5;
  double max_range_m = 80.0;
  int directions = 720;

  void describe(ConfigSchema& schema);
};

/// The scan that a cloud of points shows in a band of heights, all around the sensor: in each
/// direction the nearest point of the band; no return (+inf) where there are only points above,
/// below or beyond, and no measurement (NaN) where there are none at all. Points are (x, y) from
/// the sensor, its x axis ahead, and z above base_link; those that are not finite are left out.
/// `times_s`: when each was measured, 0 or more after `time_s`; as many as points, or none. The
/// scan then knows the times of its beams (of the point that a direction shows), and begins where
/// the turn does.
LaserScan scanOfPoints(const std::vector<Eigen::Vector3f>& points, double time_s,
                       const PointCloudConfig& config, const std::vector<float>& times_s = {});

/// Whether a point says anything in such a scan: it is finite, and not of the vehicle.
bool isSeen(const Eigen::Vector3f& point, const PointCloudConfig& config);

}  // namespace hymm::core
