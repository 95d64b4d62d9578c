#pragma once

#include <cmath>
#include <vector>

#include "common/random.h"
#include "pipeline/sensor_event.h"

namespace hymm::test {

/// A robot that drives a square of 40 m among posts that its own detector sees, and comes back.
/// Seeded; with `identities` each observation tells of which post it is.
class LoopDrive {
 public:
  explicit LoopDrive(std::uint64_t seed, bool identities = false)
      : generator_(seed), identities_(identities) {
    for (double along = -5.0; along < 45.0; along += 7.0) {
      for (const double across : {-6.0, 6.0, 34.0, 46.0}) {
        posts_.emplace_back(along + jitter(), across + jitter());
        posts_.emplace_back(across + jitter(), along + jitter());
      }
    }
  }

  /// Motion and the scan after it; each half a second.
  std::vector<core::SensorEvent> next() {
    const double step_s = 0.5, speed = 2.0;
    const double side_s = 20.0, turn_s = 1.0;
    const double in_side = std::fmod(time_s_, side_s + turn_s);
    const double yaw_rate = in_side < side_s ? 0.0 : 0.5 * core::kPi / turn_s;
    const double v = in_side < side_s ? speed : 0.0;
    std::vector<core::SensorEvent> events;
    events.push_back(core::MotionInput{
        core::TwistInput{time_s_, v + 0.05 * core::sampleNormal(generator_, 1.0), 0.0,
                         yaw_rate + 0.01 * core::sampleNormal(generator_, 1.0)}});
    truth_ = truth_ * core::Pose2{v * step_s, 0.0, yaw_rate * step_s};
    time_s_ += step_s;
    events.push_back(observe());
    return events;
  }

  const core::Pose2& truth() const { return truth_; }
  double time_s() const { return time_s_; }

 private:
  double jitter() { return core::sampleNormal(generator_, 0.7); }

  core::ObservationSet observe() {
    core::ObservationSet set;
    set.time_s = time_s_;
    for (std::size_t i = 0; i < posts_.size(); ++i) {
      const Eigen::Vector2d p = core::inverse(truth_) * posts_[i];
      if (p.norm() > 12.0 || p.norm() < 1.0) continue;
      core::Observation observation;
      observation.range_m = p.norm() + 0.05 * core::sampleNormal(generator_, 1.0);
      observation.bearing_rad =
          std::atan2(p.y(), p.x()) + 0.005 * core::sampleNormal(generator_, 1.0);
      observation.covariance = Eigen::Vector2d(0.0025, 2.5e-5).asDiagonal();
      if (identities_) observation.identity = static_cast<int>(i);
      set.observations.push_back(observation);
    }
    return set;
  }

  core::RandomGenerator generator_;
  bool identities_;
  std::vector<Eigen::Vector2d> posts_;
  core::Pose2 truth_;
  double time_s_ = 0.0;
};

}  // namespace hymm::test
