#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "cekf/landmark_map.h"

namespace hymm::test {

/// Three landmarks, 0 to 2, that span an LTR: seen often, and far more certain of each other than
/// of map.
inline core::LandmarkMap landmarkTriangle(const std::array<Eigen::Vector2d, 3>& places,
                                          std::uint64_t version = 1) {
  core::LandmarkMap map;
  map.version = version;
  for (int id = 0; id < 3; ++id) {
    core::LandmarkEstimate landmark;
    landmark.id = id;
    landmark.position = places[std::size_t(id)];
    landmark.covariance = 0.01 * Eigen::Matrix2d::Identity();
    landmark.observations = 20;
    map.landmarks.push_back(landmark);
    for (int other = 0; other < id; ++other) {
      map.cross_covariances.push_back({other, id, 0.0099 * Eigen::Matrix2d::Identity()});
    }
  }
  return map;
}

}  // namespace hymm::test
