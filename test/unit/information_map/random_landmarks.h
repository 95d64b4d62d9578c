#pragma once

#include <vector>

#include <Eigen/Core>

#include "cekf/landmark_map.h"
#include "common/pose2.h"
#include "common/random.h"

namespace hymm::core {

/// A map of landmarks at `places` with the joint covariance `P`, all pairs told.
inline LandmarkMap mapOf(const std::vector<Eigen::Vector2d>& places, const Eigen::MatrixXd& P,
                         std::uint64_t version = 1) {
  LandmarkMap map;
  map.version = version;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto row = Eigen::Index(2 * i);
    LandmarkEstimate landmark;
    landmark.id = static_cast<int>(i);
    landmark.position = places[i];
    landmark.covariance = P.block<2, 2>(row, row);
    landmark.observations = 10;
    map.landmarks.push_back(landmark);
    for (std::size_t j = 0; j < i; ++j) {
      map.cross_covariances.push_back(
          {static_cast<int>(j), static_cast<int>(i), P.block<2, 2>(Eigen::Index(2 * j), row)});
    }
  }
  return map;
}

/// Uniform in a disc around the origin, but not nearer to it than 2 m.
inline std::vector<Eigen::Vector2d> randomPlaces(int count, double radius_m,
                                                 RandomGenerator& generator) {
  std::vector<Eigen::Vector2d> places;
  while (static_cast<int>(places.size()) < count) {
    const Eigen::Vector2d place(sampleUniform(generator, -radius_m, radius_m),
                                sampleUniform(generator, -radius_m, radius_m));
    if (place.norm() < radius_m && place.norm() > 2.0) places.push_back(place);
  }
  return places;
}

/// As of a SLAM map: an error that all landmarks share, a turn of all about a far place, and small
/// errors of each. [m^2]
inline Eigen::MatrixXd randomCovariance(const std::vector<Eigen::Vector2d>& places,
                                        RandomGenerator& generator) {
  const auto n = Eigen::Index(places.size());
  Eigen::MatrixXd modes(2 * n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector2d& p = places[std::size_t(i)];
    modes.block<2, 3>(2 * i, 0) << 0.3, 0.0, -0.01 * (p.y() + 20.0), 0.0, 0.3, 0.01 * (p.x() - 30);
  }
  Eigen::MatrixXd own(2 * n, 2 * n);
  for (double& entry : own.reshaped()) entry = sampleNormal(generator, 0.02);
  return modes * modes.transpose() + own * own.transpose() / double(2 * n) +
         1e-4 * Eigen::MatrixXd::Identity(2 * n, 2 * n);
}

}  // namespace hymm::core
