#pragma once

#include <cstdint>

#include <gtest/gtest.h>

#include "hybrid_map/hybrid_map.h"
#include "landmark_maps.h"

namespace hymm::core {

/// What one beam says of the cell in which it ends.
inline const double kHit = OccupancyConfig().hit_probability;

/// Two layers beside the occupancy.
inline HybridMapConfig withLayers() {
  HybridMapConfig config;
  config.layers = "salinity gaussian; terrain category grass asphalt";
  return config;
}

/// A square of 20 m around the origin in two LTRs.
inline LandmarkMap squareMap() {
  return mapOf({{-10.0, -10.0}, {10.0, -10.0}, {10.0, 10.0}, {-10.5, 10.0}});
}

/// A scan of one beam.
inline PosedScan beam(const Pose2& T_map_laser, double range_m, std::uint64_t version = 1) {
  PosedScan posed;
  posed.T_map_laser = T_map_laser;
  posed.map_version = version;
  posed.scan.angle_increment_rad = 0.01;
  posed.scan.range_max_m = 80.0;
  posed.scan.ranges_m = {static_cast<float>(range_m)};
  return posed;
}

inline PropertySample salinity(const Eigen::Vector2d& place, double value) {
  PropertySample sample;
  sample.layer = "salinity";
  sample.position = place;
  sample.sample.value = value;
  sample.sample.variance = 0.01;
  return sample;
}

inline double probabilityAt(const HybridMap& map, const Eigen::Vector2d& place) {
  const LayerQuery answer = map.query("occupancy", place);
  return answer.value ? answer.value->value : 0.5;
}

inline HybridMap mapOver(const LandmarkMap& landmarks,
                         const HybridMapConfig& config = withLayers()) {
  HybridMap map(config);
  EXPECT_TRUE(map.apply(landmarks).accepted);
  return map;
}

}  // namespace hymm::core
