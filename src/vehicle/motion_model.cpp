#include "vehicle/motion_model.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"
#include "vehicle/arc.h"

namespace hymm::core {
namespace {

// tan(steering) * offset / wheelbase stays below this, so that the wheel never stands still in the
// formula of the paper's vehicle while the car turns around it.
constexpr double kLargestWheelShare = 0.9;

double square(double value) { return value * value; }

/// Density [unit^2 s] of an error with this deviation that persists over `correlation_time_s`.
double densityOf(double deviation, double correlation_time_s) {
  return 2.0 * square(deviation) * correlation_time_s;
}

}  // namespace

MotionModel::MotionModel(const VehicleConfig& vehicle)
    : geometry_(vehicle.ackermann), noise_(vehicle.noise) {
  const double share = std::tan(vehicle.max_steering_rad) *
                       std::abs(geometry_.encoder_offset_left_m) / geometry_.wheelbase_m;
  if (share >= kLargestWheelShare) {
    throw ConfigError(
        {"vehicle: at max_steering_rad the turning centre reaches the encoder's wheel;"
         " check wheelbase_m, encoder_offset_left_m and max_steering_rad."});
  }
}

BodyVelocity MotionModel::velocity(const AckermannInput& input, const Calibration& calibration,
                                   const MotionError& error) const {
  const double L = geometry_.wheelbase_m, H = geometry_.encoder_offset_left_m;
  const double speed_deviation =
      std::hypot(noise_.speed_deviation_mps, noise_.speed_deviation_relative * input.speed_mps);
  const double relative_deviation = noise_.steering_deviation_relative * input.steering_rad;
  const double wheel_speed =
      calibration.speed_scale * input.speed_mps + speed_deviation * error.speed;
  const double steering = calibration.turn_scale * input.steering_rad + calibration.turn_offset +
                          noise_.steering_deviation_rad * error.turn +
                          relative_deviation * error.turn_relative;
  double t = std::tan(std::clamp(steering, -1.4, 1.4));
  if (t * H / L > kLargestWheelShare) t = kLargestWheelShare * L / H;
  const double D = 1.0 - t * H / L;

  BodyVelocity v;
  v.forward_mps = wheel_speed / D;
  v.yaw_rate_radps = v.forward_mps * t / L;

  const Eigen::Vector3d d_speed(1.0 / D, 0.0, t / (L * D));  // of the velocity by the wheel's speed
  const double d_forward_by_t = v.forward_mps * H / (L * D);
  const Eigen::Vector3d d_steering =
      (1.0 + t * t) *
      Eigen::Vector3d(d_forward_by_t, 0.0, (v.forward_mps + t * d_forward_by_t) / L);
  v.J_readings << d_speed, Eigen::Vector3d::Zero(), d_steering;
  v.J_calibration = v.calibrationJacobian(readingsOf(input));
  v.J_error << speed_deviation * d_speed, noise_.steering_deviation_rad * d_steering,
      relative_deviation * d_steering;
  v.white_density(1, 1) =
      densityOf(noise_.lateral_deviation_relative * v.forward_mps, noise_.correlation_time_s);
  return v;
}

BodyVelocity MotionModel::velocity(const TwistInput& input, const Calibration& calibration,
                                   const MotionError& error) const {
  const double speed = std::hypot(input.forward_mps, input.lateral_mps);
  const Eigen::Vector2d direction =
      speed > 0.0 ? Eigen::Vector2d(input.forward_mps / speed, input.lateral_mps / speed)
                  : Eigen::Vector2d::UnitX();
  BodyVelocity v;
  v.J_readings.setIdentity();
  v.J_calibration = v.calibrationJacobian(readingsOf(input));
  if (input.density) {
    v.white_density = *input.density;
  } else {
    const double speed_deviation =
        std::hypot(noise_.speed_deviation_mps, noise_.speed_deviation_relative * speed);
    v.J_error << speed_deviation * direction.x(), 0.0, 0.0,  //
        speed_deviation * direction.y(), 0.0, 0.0,           //
        0.0, noise_.yaw_rate_deviation_radps,
        noise_.yaw_rate_deviation_relative * input.yaw_rate_radps;
    v.white_density(1, 1) =
        densityOf(noise_.lateral_deviation_relative * speed, noise_.correlation_time_s);
  }
  v.forward_mps = calibration.speed_scale * input.forward_mps + v.J_error(0, 0) * error.speed;
  v.lateral_mps = calibration.speed_scale * input.lateral_mps + v.J_error(1, 0) * error.speed;
  v.yaw_rate_radps = calibration.turn_scale * input.yaw_rate_radps + calibration.turn_offset +
                     v.J_error(2, 1) * error.turn + v.J_error(2, 2) * error.turn_relative;
  return v;
}

BodyVelocity MotionModel::velocity(const MotionInput& input, const Calibration& calibration,
                                   const MotionError& error) const {
  return std::visit([&](const auto& value) { return velocity(value, calibration, error); }, input);
}

MotionStep MotionModel::step(const Pose2& pose, const MotionInput& input,
                             const Calibration& calibration, double age_s, double duration_s,
                             const MotionError& error,
                             const std::optional<MotionReadings>& scaled) const {
  const BodyVelocity v = velocity(input, calibration, error);
  const double turn = v.yaw_rate_radps * duration_s;
  const Arc arc(turn);
  const Eigen::Vector2d chord(v.forward_mps * duration_s, v.lateral_mps * duration_s);
  const Eigen::Matrix2d R = pose.rotation();
  const Eigen::Vector2d moved = R * arc.V() * chord;

  MotionStep step;
  step.pose = {pose.x_m + moved.x(), pose.y_m + moved.y(), wrapAngle(pose.yaw_rad + turn)};
  step.J_pose(0, 2) = -moved.y();
  step.J_pose(1, 2) = moved.x();

  Eigen::Matrix3d J_velocity = arc.velocityJacobian(chord, duration_s);
  J_velocity.topRows<2>() = R * J_velocity.topRows<2>().eval();
  step.J_velocity = J_velocity;
  step.J_calibration = J_velocity * (scaled ? v.calibrationJacobian(*scaled) : v.J_calibration);
  step.J_error = J_velocity * v.J_error;
  if (duration_s > 0.0) {
    // White noise of the velocity: its covariance over the step is density / duration.
    Eigen::Matrix3d density = v.white_density;
    density.diagonal() += gapDensity(age_s + duration_s);
    step.white_covariance = density / duration_s;
    step.noise = step.whiteNoise(Eigen::Vector3d::Ones()) +
                 step.J_error * (2.0 / duration_s * correlationTimes()).asDiagonal() *
                     step.J_error.transpose();
  }
  return step;
}

Eigen::Vector3d MotionModel::gapDensity(double age_s) const {
  const double beyond_s = age_s - noise_.hold_limit_s;
  if (beyond_s <= 0.0) return Eigen::Vector3d::Zero();
  // The error of an input that never came persists through the whole gap.
  const double tau = std::max(beyond_s, noise_.correlation_time_s);
  const double q_speed = densityOf(noise_.gap_acceleration_mps2 * beyond_s, tau);
  return {q_speed, 0.0, densityOf(noise_.gap_yaw_rate_deviation_radps, tau)};
}

}  // namespace hymm::core
