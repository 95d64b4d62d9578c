#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "relocaliser/relocaliser.h"

namespace hymm::core {

inline constexpr double kScanPeriod_s = 0.2;

/// A car whose laser looks ahead, a half turn, 25 m far.
inline VehicleConfig vehicle() {
  VehicleConfig config;
  config.laser = {2.0, 0.3, 0.0};
  return config;
}

/// An irregular stand of trees.
inline LocalMap stand() {
  LocalMap map;
  const std::vector<Eigen::Vector2d> places{{8, 5},   {12, -6}, {17, 3},  {21, -9}, {26, 7},
                                            {33, -4}, {38, 9},  {44, -7}, {50, 4},  {57, -5}};
  for (std::size_t i = 0; i < places.size(); ++i) {
    map.landmarks.push_back({static_cast<int>(i), places[i], 0.0025 * Eigen::Matrix2d::Identity()});
  }
  map.vehicle.covariance = Eigen::Vector3d(4.0, 4.0, 0.01).asDiagonal();
  return map;
}

inline Observation observed(double range_m, double bearing_rad) {
  Observation observation;
  observation.range_m = range_m;
  observation.bearing_rad = bearing_rad;
  observation.covariance = Eigen::Vector2d(0.0025, 0.000025).asDiagonal();
  return observation;
}

/// What the laser of a vehicle at `T_map_base` sees of landmarks, without an error.
template <class Landmarks>
ObservationSet seenFrom(const Pose2& T_map_base, const Landmarks& landmarks, double time_s) {
  ObservationSet set{time_s, vehicle().laser.T_base_sensor(), {}};
  for (const auto& landmark : landmarks) {
    const Eigen::Vector2d p = inverse(T_map_base * set.T_base_sensor) * landmark.position;
    const Observation observation = observed(p.norm(), std::atan2(p.y(), p.x()));
    if (observation.range_m > 25.0 || std::abs(observation.bearing_rad) > kPi / 2.0) continue;
    set.observations.push_back(observation);
  }
  return set;
}

}  // namespace hymm::core
