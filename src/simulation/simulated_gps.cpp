#include "simulation/simulated_gps.h"

#include <limits>

namespace hymm::core {
namespace {

double sampleExponential(RandomGenerator& generator, double mean) {
  return std::exponential_distribution<double>(1.0 / mean)(generator);
}

}  // namespace

SimulatedGps::SimulatedGps(const SimulatedGpsConfig& config, RandomGenerator generator,
                           double start_s)
    : config_(config),
      generator_(generator),
      drift_x_(config.drift_time_s, generator_),
      drift_y_(config.drift_time_s, generator_),
      outage_{config.outage_interval_s, config.outage_duration_s},
      jump_{config.jump_interval_s, config.jump_duration_s},
      last_s_(start_s) {
  start(outage_, start_s);
  start(jump_, start_s);
}

void SimulatedGps::start(Spell& spell, double time_s) {
  spell.until_s = spell.interval_s > 0.0 ? time_s + sampleExponential(generator_, spell.interval_s)
                                         : std::numeric_limits<double>::infinity();
}

bool SimulatedGps::advance(Spell& spell, double time_s) {
  bool began = false;
  while (time_s >= spell.until_s) {
    spell.active = !spell.active;
    began = began || spell.active;
    spell.until_s +=
        sampleExponential(generator_, spell.active ? spell.duration_s : spell.interval_s);
  }
  return began;
}

std::optional<GpsFix> SimulatedGps::fix(const Eigen::Vector2d& position,
                                        const Eigen::Vector2d& antenna, double time_s) {
  drift_x_.advance(time_s - last_s_, generator_);
  drift_y_.advance(time_s - last_s_, generator_);
  last_s_ = time_s;
  advance(outage_, time_s);
  if (advance(jump_, time_s)) {
    jump_offset_.x() = sampleNormal(generator_, config_.jump_deviation_m);
    jump_offset_.y() = sampleNormal(generator_, config_.jump_deviation_m);
  }
  const double x_error = sampleNormal(generator_, config_.deviation_m);
  const double y_error = sampleNormal(generator_, config_.deviation_m);
  if (outage_.active) return std::nullopt;

  GpsFix fix;
  fix.time_s = time_s;
  fix.antenna = antenna;
  fix.position = position + Eigen::Vector2d(x_error, y_error) +
                 config_.drift_deviation_m * Eigen::Vector2d(drift_x_.value(), drift_y_.value());
  if (jump_.active) fix.position += jump_offset_;
  const double variance = config_.deviation_m * config_.deviation_m +
                          config_.drift_deviation_m * config_.drift_deviation_m;
  fix.covariance = std::max(variance, 1e-6) * Eigen::Matrix2d::Identity();
  return fix;
}

}  // namespace hymm::core
