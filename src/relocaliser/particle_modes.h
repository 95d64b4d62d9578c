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
  /// Of (x [m], y [m], yaw [rad]): what can be told from so many effective particles.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();  ///< of the weighted particles themselves
  double effective_number = 0.0;
};

/// The covariance that is told of a mode of n effective particles is that of where another sample
/// of the same distribution will be found, as n samples of a Gaussian let it be known: the weighted
/// moments times (n + 1) / (n - 5) in three dimensions. Where fewer than 14 are effective, that
/// says little: the weights are narrower than the particles stand apart. There each particle stands
/// for a kernel, whose covariance is added: that of the particles about the heaviest with log
/// weights scaled down until 14 are effective. Spread evenly, particles make n grow with the cube
/// of the width that they are taken from, and this n makes the told width least. It is taken from
/// the bins about the heaviest alone: what is farther off are other peaks, which the moments hold.
///
/// All modes that hold at least `least_share` of the weight, the heaviest first.
std::vector<ParticleMode> computeModes(const ParticleSet& particles, const BinSize& bin,
                                       double least_share);

/// Number of bins that hold one of `indices`.
std::size_t countBins(const ParticleSet& particles, const std::vector<std::size_t>& indices,
                      const BinSize& bin);

}  // namespace hymm::core
