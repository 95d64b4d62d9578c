#pragma once

#include <cstdint>
#include <random>

#include <Eigen/Core>

namespace hymm::core {

/// The one source of randomness: seeded by its owner and passed in, never global.
using RandomGenerator = std::mt19937_64;

inline double sampleNormal(RandomGenerator& generator, double deviation) {
  return std::normal_distribution<double>(0.0, 1.0)(generator) * deviation;
}

inline double sampleUniform(RandomGenerator& generator, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(generator);
}

}  // namespace hymm::core
