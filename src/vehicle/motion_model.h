#pragma once

#include <optional>

#include <Eigen/Core>

#include "common/pose2.h"
#include "vehicle/motion_input.h"
#include "vehicle/vehicle_config.h"

namespace hymm::core {

/// Corrections of the motion input, nominally (1, 1, 0). The true input is
///   speed = speed_scale * measured, turn = turn_scale * measured + turn_offset,
/// where turn is the steering angle [rad] (Ackermann) or the yaw rate [rad/s] (twist).
struct Calibration {
  double speed_scale = 1.0;
  double turn_scale = 1.0;
  double turn_offset = 0.0;

  Eigen::Vector3d vector() const { return {speed_scale, turn_scale, turn_offset}; }
  static Calibration fromVector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
};

/// Errors of the motion input that persist for a while (MotionNoise), in units of their deviations:
/// the true speed and turn are those measured, plus error times deviation. The turn's error has a
/// constant part and one that is relative to the turn, of the turn's sign.
struct MotionError {
  double speed = 0.0;
  double turn = 0.0;
  double turn_relative = 0.0;

  static MotionError fromVector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
};

/// Velocity of base_link after calibration, and how it depends on calibration and errors.
struct BodyVelocity {
  double forward_mps = 0.0;
  double lateral_mps = 0.0;
  double yaw_rate_radps = 0.0;
  Eigen::Matrix3d J_calibration = Eigen::Matrix3d::Zero();  ///< d(forward, lateral, yaw rate)/d(c)
  Eigen::Matrix3d J_readings = Eigen::Matrix3d::Zero();     ///< by MotionReadings, calibrated
  Eigen::Matrix3d J_error = Eigen::Matrix3d::Zero();        ///< by MotionError
  Eigen::Matrix3d white_density = Eigen::Matrix3d::Zero();  ///< all other noise, (unit)^2 * s

  /// What J_calibration is where the scales multiply `scaled`.
  Eigen::Matrix3d calibrationJacobian(const MotionReadings& scaled) const {
    const Eigen::Vector3d readings = scaled.vector();
    Eigen::Matrix3d J;
    J << J_readings.leftCols<2>() * readings.head<2>(), J_readings.col(2) * readings.z(),
        J_readings.col(2);
    return J;
  }

  /// Of the velocity at one moment, with white noise averaged over twice the correlation time.
  Eigen::Matrix3d covariance(double correlation_time_s) const {
    return J_error * J_error.transpose() + white_density / (2.0 * correlation_time_s);
  }
};

/// One step of motion: the pose after it and what a filter needs to carry its covariance along.
struct MotionStep {
  Pose2 pose;
  Eigen::Matrix3d J_pose = Eigen::Matrix3d::Identity();     ///< d(pose')/d(pose)
  Eigen::Matrix3d J_calibration = Eigen::Matrix3d::Zero();  ///< d(pose')/d(calibration)
  Eigen::Matrix3d J_error = Eigen::Matrix3d::Zero();        ///< by MotionError
  Eigen::Matrix3d J_velocity = Eigen::Matrix3d::Zero();     ///< by (forward, lateral, yaw rate)
  /// Of the velocity, of all noise but MotionError, averaged over the step.
  Eigen::Matrix3d white_covariance = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d noise =
      Eigen::Matrix3d::Zero();  ///< covariance added, MotionError taken as white

  /// Covariance added without MotionError, if its deviations are so many times as large.
  Eigen::Matrix3d whiteNoise(const Eigen::Vector3d& times) const {
    const Eigen::Matrix3d J = J_velocity * times.asDiagonal();
    return J * white_covariance * J.transpose();
  }
};

/// Motion of a planar vehicle from encoder speed and steering, or from a twist; noise from
/// parameters with physical meaning (MotionNoise). Over steps much longer than its correlation time
/// an error acts as white noise of density 2 * deviation^2 * correlation time; over shorter ones it
/// is a bias, which a filter carries as a state. Immutable and cheap to copy.
class MotionModel {
 public:
  /// Throws ConfigError if the geometry is unusable.
  explicit MotionModel(const VehicleConfig& vehicle);

  BodyVelocity velocity(const AckermannInput& input, const Calibration& calibration,
                        const MotionError& error = {}) const;
  BodyVelocity velocity(const TwistInput& input, const Calibration& calibration,
                        const MotionError& error = {}) const;
  BodyVelocity velocity(const MotionInput& input, const Calibration& calibration,
                        const MotionError& error = {}) const;

  /// Moves `pose` for `duration_s` at constant velocity, along the exact arc. `age_s` is how old
  /// the input is when the step begins: beyond hold_limit_s the noise grows as for an unknown
  /// input. `scaled`: what J_calibration takes the scales to multiply, if not the input itself; see
  /// EarlierReadings.
  MotionStep step(const Pose2& pose, const MotionInput& input, const Calibration& calibration,
                  double age_s, double duration_s, const MotionError& error = {},
                  const std::optional<MotionReadings>& scaled = std::nullopt) const;

  /// How long each MotionError persists [s].
  Eigen::Vector3d correlationTimes() const { return noise_.correlationTimes_s(); }

 private:
  Eigen::Vector3d gapDensity(double age_s) const;

  AckermannGeometry geometry_;
  MotionNoise noise_;
};

}  // namespace hymm::core
