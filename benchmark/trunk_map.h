#pragma once

#include <vector>

#include <Eigen/Core>

#include "cekf/landmark_map.h"

namespace hymm::benchmarks {

/// A map of landmarks of which a filter is sure, at these places: enough observations and known
/// covariances of near pairs, so that they can span LTRs.
inline core::LandmarkMap certainLandmarks(const std::vector<Eigen::Vector2d>& places) {
  constexpr double kPairRange_m = 30.0;
  core::LandmarkMap map;
  map.version = 1;
  for (std::size_t i = 0; i < places.size(); ++i) {
    core::LandmarkEstimate landmark;
    landmark.id = static_cast<int>(i);
    landmark.position = places[i];
    landmark.covariance = 0.01 * Eigen::Matrix2d::Identity();
    landmark.observations = 50;
    map.landmarks.push_back(landmark);
    for (std::size_t j = 0; j < i; ++j) {
      if ((places[i] - places[j]).norm() > kPairRange_m) continue;
      map.cross_covariances.push_back(
          {static_cast<int>(j), static_cast<int>(i), 0.009 * Eigen::Matrix2d::Identity()});
    }
  }
  return map;
}

}  // namespace hymm::benchmarks
