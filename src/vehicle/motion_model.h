#pragma once

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

/// Velocity of base_link after calibration, and how it depends on the calibration.
struct BodyVelocity {
  double forward_mps = 0.0;
  double lateral_mps = 0.0;
  double yaw_rate_radps = 0.0;
  Eigen::Matrix3d J_calibration = Eigen::Matrix3d::Zero();  ///< d(forward, lateral, yaw rate)/d(c)
  Eigen::Matrix3d density = Eigen::Matrix3d::Zero();        ///< noise of the velocity, (unit)^2 * s
};

/// One step of motion: the pose after it and what a filter needs to carry its covariance along.
struct MotionStep {
  Pose2 pose;
  Eigen::Matrix3d J_pose = Eigen::Matrix3d::Identity();     ///< d(pose')/d(pose)
  Eigen::Matrix3d J_calibration = Eigen::Matrix3d::Zero();  ///< d(pose')/d(calibration)
  Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();          ///< covariance added to pose'
};

/// Motion of a planar vehicle from encoder speed and steering, or from a twist; noise from
/// parameters with physical meaning (MotionNoise). Immutable and cheap to copy.
class MotionModel {
 public:
  /// Throws ConfigError if the geometry is unusable.
  explicit MotionModel(const VehicleConfig& vehicle);

  BodyVelocity velocity(const AckermannInput& input, const Calibration& calibration) const;
  BodyVelocity velocity(const TwistInput& input, const Calibration& calibration) const;
  BodyVelocity velocity(const MotionInput& input, const Calibration& calibration) const;

  /// Moves `pose` for `duration_s` at constant velocity, along the exact arc. `age_s` is how old
  /// the input is when the step begins: beyond hold_limit_s the noise grows as for an unknown
  /// input.
  MotionStep step(const Pose2& pose, const MotionInput& input, const Calibration& calibration,
                  double age_s, double duration_s) const;

 private:
  Eigen::Vector3d gapDensity(double age_s) const;

  AckermannGeometry geometry_;
  MotionNoise noise_;
};

}  // namespace hymm::core
