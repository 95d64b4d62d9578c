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
};

using MotionInput = std::variant<AckermannInput, TwistInput>;

inline double timeOf(const MotionInput& input) {
  return std::visit([](const auto& value) { return value.time_s; }, input);
}

inline bool isFinite(const MotionInput& input) {
  struct Check {
    bool operator()(const AckermannInput& i) const {
      return std::isfinite(i.time_s) && std::isfinite(i.speed_mps) && std::isfinite(i.steering_rad);
    }
    bool operator()(const TwistInput& i) const {
      return std::isfinite(i.time_s) && std::isfinite(i.forward_mps) &&
             std::isfinite(i.lateral_mps) && std::isfinite(i.yaw_rate_radps) &&
             (!i.density || i.density->allFinite());
    }
  };
  return std::visit(Check{}, input);
}

}  // namespace hymm::core
