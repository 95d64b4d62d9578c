#pragma once

#include <cstddef>
#include <vector>

#include "common/config.h"
#include "common/random.h"
#include "relocaliser/density_map.h"
#include "relocaliser/particle_kernels.h"
#include "relocaliser/particle_modes.h"
#include "relocaliser/particle_set.h"

namespace hymm::core {

struct ParticleFilterConfig {
  int min_particles = 2000;
  int max_particles = 100000;
  double resample_below = 0.5;   ///< effective share of the particles
  double kld_error = 0.03;       ///< of the sampled distribution against the true one, in nats
  double kld_deviations = 2.33;  ///< quantile with which the error holds: 99 %
  double bin_m = 0.5;            ///< bins by which the spread is counted
  double bin_rad = 0.1;
  double roughening_m = 0.03;  ///< of particles that are copied
  double roughening_rad = 0.003;

  BinSize bin() const { return {bin_m, bin_rad}; }
  void describe(ConfigSchema& schema);
};

/// Number of samples with which the Kullback-Leibler distance of the sampled distribution from the
/// true one, over `bins` bins, stays below `error` with the quantile `deviations` (Fox, 2003).
double kldSampleNumber(std::size_t bins, double error, double deviations);

/// Indices of `count` particles drawn in proportion to `weight` with one random number, `start` in
/// [0, 1): low-variance resampling.
std::vector<std::size_t> drawLowVariance(const std::vector<float>& weight, std::size_t count,
                                         double start);

/// Sampling importance resampling without data association.
class ParticleFilter {
 public:
  explicit ParticleFilter(const ParticleFilterConfig& config);

  /// Begins anew with these particles and weights.
  void begin(ParticleSet particles);
  void move(const NoisyStep& step, RandomGenerator& generator);
  /// Weighs the particles by all lookups of `map`.
  void weigh(const DensityMap& map);
  /// Resamples if the effective number has fallen so far, to as many as the spread needs. Returns
  /// whether it did.
  bool resampleIfDue(RandomGenerator& generator);

  const ParticleSet& particles() const { return particles_; }
  double effectiveNumber() const { return sums_.effectiveNumber(); }

 private:
  void resample(RandomGenerator& generator);

  ParticleFilterConfig config_;
  ParticleSet particles_, spare_;
  WeightSums sums_;
};

}  // namespace hymm::core
