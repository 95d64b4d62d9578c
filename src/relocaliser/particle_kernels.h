#pragma once

#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include "relocaliser/particle_set.h"

namespace hymm::core {

/// A table over the plane that is looked up at the nearest cell; beyond its border the border's own
/// value holds.
struct LookupGrid {
  float origin_x_m = 0.0F;  ///< least corner of cell (0, 0)
  float origin_y_m = 0.0F;
  float cells_per_m = 1.0F;
  std::int32_t width = 1;
  std::int32_t height = 1;
};

/// A point seen from the vehicle, and the table of what it is worth where it falls.
struct LookupPoint {
  float x_m = 0.0F;              ///< base frame
  float y_m = 0.0F;              ///< base frame
  const float* table = nullptr;  ///< row-major, width * height
};

/// Adds to the log weight of each particle what `table` of each point holds where the particle puts
/// that point.
void addLookups(const LookupGrid& grid, const LookupPoint* points, std::size_t count,
                ParticleSet& particles);

/// A step of motion in the vehicle's own axes, with noise.
struct NoisyStep {
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();  ///< forward [m], left [m], turn [rad]
  Eigen::Matrix3f root = Eigen::Matrix3f::Zero();  ///< lower; root * root' is the covariance
};

/// Moves each particle by a sample of `step`. The samples depend on `seed` and on each particle's
/// index alone.
void moveParticles(const NoisyStep& step, std::uint64_t seed, ParticleSet& particles);

/// Sums that weights are judged by.
struct WeightSums {
  double sum = 0.0;          ///< of the weights, the greatest being 1
  double sum_squares = 0.0;  ///< of the same
  double effectiveNumber() const { return sum_squares > 0.0 ? sum * sum / sum_squares : 0.0; }
};

/// Shifts the log weights so that the greatest is zero, computes the weights and sums them. Weights
/// that are not finite become the least there is.
WeightSums normaliseWeights(ParticleSet& particles);

}  // namespace hymm::core
