#include "relocaliser/particle_filter.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {

void ParticleFilterConfig::describe(ConfigSchema& schema) {
  schema.integer("min_particles", min_particles, Range::between(100, 1000000), "fewest particles");
  schema.integer("max_particles", max_particles, Range::between(1000, 5000000), "most particles");
  schema.number("resample_below", resample_below, Range::between(0.05, 1.0),
                "effective share of the particles below which they are resampled");
  schema.number(
      "kld_error", kld_error, Range{0.001, 1.0},
      "admitted error of the sampled distribution, in nats; sets the number of particles");
  schema.number("kld_deviations", kld_deviations, Range::between(0.5, 5.0),
                "quantile of the normal distribution with which kld_error holds");
  schema.number("bin_m", bin_m, Range{0.05, 10.0},
                "size of the bins by which the spread is counted");
  schema.number("bin_rad", bin_rad, Range{0.01, 1.0}, "the same of the heading");
  schema.number("roughening_m", roughening_m, Range::between(0.0, 1.0),
                "deviation by which resampled particles are spread");
  schema.number("roughening_rad", roughening_rad, Range::between(0.0, 0.5),
                "the same of the heading");
}

double kldSampleNumber(std::size_t bins, double error, double deviations) {
  if (bins < 2) return 1.0;
  const double k = static_cast<double>(bins - 1);
  const double a = 2.0 / (9.0 * k);
  return k / (2.0 * error) * std::pow(1.0 - a + std::sqrt(a) * deviations, 3);
}

std::vector<std::size_t> drawLowVariance(const std::vector<float>& weight, std::size_t count,
                                         double start) {
  double total = 0.0;
  for (const float value : weight) total += static_cast<double>(value);
  std::vector<std::size_t> drawn(count);
  const double pitch = total / static_cast<double>(count);
  double next = start * pitch, reached = 0.0;
  std::size_t filled = 0, last = 0;
  for (std::size_t i = 0; i < weight.size() && filled < count; ++i) {
    reached += static_cast<double>(weight[i]);
    for (; next < reached && filled < count; next += pitch) {
      drawn[filled++] = i;
      last = i;
    }
  }
  // Rounding may leave the last ones undrawn.
  std::fill(drawn.begin() + static_cast<std::ptrdiff_t>(filled), drawn.end(), last);
  return drawn;
}

ParticleFilter::ParticleFilter(const ParticleFilterConfig& config) : config_(config) {}

void ParticleFilter::begin(ParticleSet particles) {
  particles_ = std::move(particles);
  sums_ = normaliseWeights(particles_);
}

void ParticleFilter::move(const NoisyStep& step, RandomGenerator& generator) {
  moveParticles(step, generator(), particles_);
}

void ParticleFilter::weigh(const DensityMap& map) {
  addLookups(map.grid(), map.lookups().data(), map.lookups().size(), particles_);
  sums_ = normaliseWeights(particles_);
}

bool ParticleFilter::resampleIfDue(RandomGenerator& generator) {
  const auto count = static_cast<double>(particles_.size());
  if (particles_.size() == 0 || effectiveNumber() >= config_.resample_below * count) return false;
  resample(generator);
  return true;
}

void ParticleFilter::resample(RandomGenerator& generator) {
  const double start = sampleUniform(generator, 0.0, 1.0);
  std::vector<std::size_t> drawn = drawLowVariance(particles_.weight, particles_.size(), start);
  std::vector<std::size_t> different = drawn;
  different.erase(std::unique(different.begin(), different.end()), different.end());
  const double needed = kldSampleNumber(countBins(particles_, different, config_.bin()),
                                        config_.kld_error, config_.kld_deviations);
  const auto count =
      static_cast<std::size_t>(std::clamp(needed, static_cast<double>(config_.min_particles),
                                          static_cast<double>(config_.max_particles)));
  if (count != drawn.size()) drawn = drawLowVariance(particles_.weight, count, start);
  spare_.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    spare_.x_m[k] = particles_.x_m[drawn[k]];
    spare_.y_m[k] = particles_.y_m[drawn[k]];
    spare_.yaw_rad[k] = particles_.yaw_rad[drawn[k]];
    spare_.log_weight[k] = 0.0F;
    spare_.weight[k] = 1.0F;
  }
  std::swap(particles_, spare_);
  NoisyStep spread;
  spread.root.diagonal() << static_cast<float>(config_.roughening_m),
      static_cast<float>(config_.roughening_m), static_cast<float>(config_.roughening_rad);
  moveParticles(spread, generator(), particles_);
  sums_ = {static_cast<double>(count), static_cast<double>(count)};
}

}  // namespace hymm::core
