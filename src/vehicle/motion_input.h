#pragma once

#include <cmath>
#include <optional>
#include <variant>

#include <Eigen/Core>

namespace hymm::core {

/// What a car's encoders say. The speed is that of the wheel that carries the encoder.
struct AckermannInput {
  double time_s = 0.0;
  double speed_mps = 0.0;     ///< forward positive
  double steering_rad = 0.0;  ///< of the virtual front wheel, left positive
};

/// Velocity of base_link in its own axes.
struct TwistInput {
  double time_s = 0.0;
  double forward_mps = 0.0;
  double lateral_mps = 0.0;  ///< left positive
  double yaw_rate_radps = 0.0;
  /// Noise of (forward, lateral, yaw rate), (unit)^2 * s, where the source states it; it then takes
  /// the place of MotionNoise. Over a step of T seconds the velocity's covariance is density / T.
  std::optional<Eigen::Matrix3d> density = std::nullopt;
  /// Where it was measured over the time from `time_s` to here, as by two poses; else it is what
  /// the vehicle does from `time_s` on. Whoever has nothing newer holds either.
  std::optional<double> until_s = std::nullopt;
};

using MotionInput = std::variant<AckermannInput, TwistInput>;

/// Speed and turn as read, before calibration.
struct MotionReadings {
  double forward_mps = 0.0;  ///< of the encoder's wheel (Ackermann) or of base_link (twist)
  double lateral_mps = 0.0;  ///< twist
  double turn = 0.0;         ///< steering [rad] (Ackermann) or yaw rate [rad/s] (twist)

  Eigen::Vector3d vector() const { return {forward_mps, lateral_mps, turn}; }
  static MotionReadings fromVector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
};

inline MotionReadings readingsOf(const MotionInput& input) {
  struct Read {
    MotionReadings operator()(const AckermannInput& i) const {
      return {i.speed_mps, 0.0, i.steering_rad};
    }
    MotionReadings operator()(const TwistInput& i) const {
      return {i.forward_mps, i.lateral_mps, i.yaw_rate_radps};
    }
  };
  return std::visit(Read{}, input);
}

inline double timeOf(const MotionInput& input) {
  return std::visit([](const auto& value) { return value.time_s; }, input);
}

/// Up to when the input was measured: its time, but of a mean over an interval.
inline double endOf(const MotionInput& input) {
  const auto* twist = std::get_if<TwistInput>(&input);
  return twist != nullptr && twist->until_s ? *twist->until_s : timeOf(input);
}

inline bool isFinite(const MotionInput& input) {
  struct Check {
    bool operator()(const AckermannInput& i) const {
      return std::isfinite(i.time_s) && std::isfinite(i.speed_mps) && std::isfinite(i.steering_rad);
    }
    bool operator()(const TwistInput& i) const {
      return std::isfinite(i.time_s) && std::isfinite(i.forward_mps) &&
             std::isfinite(i.lateral_mps) && std::isfinite(i.yaw_rate_radps) &&
             (!i.density || i.density->allFinite()) && (!i.until_s || std::isfinite(*i.until_s));
    }
  };
  return std::visit(Check{}, input);
}

}  // namespace hymm::core
