#pragma once

#include <optional>

#include "common/random.h"
#include "pipeline/sensor_event.h"
#include "simulation/correlated_noise.h"
#include "simulation/simulation_config.h"

namespace hymm::core {

/// A GPS receiver: fixes with white and slowly drifting errors, outages, and jumps that its
/// covariance does not admit.
class SimulatedGps {
 public:
  SimulatedGps(const SimulatedGpsConfig& config, RandomGenerator generator, double start_s);

  /// The fix at `time_s`, later than the last; nothing during an outage. `position` is the
  /// antenna's in the local frame, `antenna` its place in base_link.
  std::optional<GpsFix> fix(const Eigen::Vector2d& position, const Eigen::Vector2d& antenna,
                            double time_s);

 private:
  /// A disturbance that comes and goes, with exponential times.
  struct Spell {
    double interval_s, duration_s;
    bool active = false;
    double until_s = 0.0;
  };

  void start(Spell& spell, double time_s);
  /// Whether the spell began anew by `time_s`.
  bool advance(Spell& spell, double time_s);

  SimulatedGpsConfig config_;
  RandomGenerator generator_;
  CorrelatedNoise drift_x_, drift_y_;
  Spell outage_, jump_;
  Eigen::Vector2d jump_offset_ = Eigen::Vector2d::Zero();
  double last_s_;
};

}  // namespace hymm::core
