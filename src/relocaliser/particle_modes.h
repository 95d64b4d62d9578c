#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "common/pose2.h"
#include "relocaliser/particle_set.h"

namespace hymm::core {

/// Cells of the pose space in which particles are counted.
struct BinSize {
  double length_m = 0.5;
  double turn_rad = 0.1;
};

/// Particles whose bins hang together.
struct ParticleMode {
  double share = 0.0;  ///< of all weight
  Pose2 mean;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x [m], y [m], yaw [rad])
};

/// All modes that hold at least `least_share` of the weight, the heaviest first.
std::vector<ParticleMode> computeModes(const ParticleSet& particles, const BinSize& bin,
                                       double least_share);

/// Number of bins that hold one of `indices`.
std::size_t countBins(const ParticleSet& particles, const std::vector<std::size_t>& indices,
                      const BinSize& bin);

}  // namespace hymm::core
