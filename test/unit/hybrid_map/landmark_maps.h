#pragma once

#include <algorithm>
#include <vector>

#include <Eigen/Core>

#include "cekf/landmark_map.h"
#include "common/random.h"

namespace hymm::core {

/// A landmark of which a filter is sure, seen often.
inline LandmarkEstimate landmarkAt(int id, const Eigen::Vector2d& position) {
  LandmarkEstimate landmark;
  landmark.id = id;
  landmark.position = position;
  landmark.covariance = 0.01 * Eigen::Matrix2d::Identity();
  landmark.observations = 50;
  return landmark;
}

/// Cross-covariances of all pairs within `range_m`: most of the error is common to all.
inline void correlate(LandmarkMap& map, double range_m = 60.0) {
  map.cross_covariances.clear();
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    for (std::size_t j = i + 1; j < map.landmarks.size(); ++j) {
      const LandmarkEstimate &a = map.landmarks[i], &b = map.landmarks[j];
      if ((a.position - b.position).norm() > range_m) continue;
      map.cross_covariances.push_back({a.id, b.id, 0.009 * Eigen::Matrix2d::Identity()});
    }
  }
}

/// Landmarks with ids 0, 1, … at these places.
inline LandmarkMap mapOf(const std::vector<Eigen::Vector2d>& positions) {
  LandmarkMap map;
  map.version = 1;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    map.landmarks.push_back(landmarkAt(static_cast<int>(i), positions[i]));
  }
  correlate(map);
  return map;
}

/// `columns` x `rows` landmarks about `spacing_m` apart, each off its place by up to a quarter.
inline LandmarkMap jitteredGrid(int columns, int rows, double spacing_m,
                                RandomGenerator& generator) {
  std::vector<Eigen::Vector2d> positions;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector2d jitter(sampleUniform(generator, -0.25, 0.25),
                                   sampleUniform(generator, -0.25, 0.25));
      positions.push_back(spacing_m * (Eigen::Vector2d(column, row) + jitter));
    }
  }
  return mapOf(positions);
}

}  // namespace hymm::core
