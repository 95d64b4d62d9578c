#pragma once

#include <optional>

#include "vehicle/motion_model.h"

namespace hymm::core {

/// Integrates motion inputs into a pose in the odom frame. Each input holds until the next.
class DeadReckoning {
 public:
  explicit DeadReckoning(const VehicleConfig& vehicle);

  /// Takes an input in time order. Returns false, and changes nothing, for a non-finite input or
  /// one that is not later than the last.
  bool process(const MotionInput& input);

  /// Back to the origin, without inputs.
  void reset();

  const Pose2& T_odom_base() const { return pose_; }
  /// Covariance of the pose since the origin, in odom axes.
  const Eigen::Matrix3d& covariance() const { return covariance_; }
  /// Velocity of the last input; nothing before the first.
  const std::optional<BodyVelocity>& velocity() const { return velocity_; }
  double time_s() const { return input_ ? timeOf(*input_) : 0.0; }

 private:
  MotionModel model_;
  Pose2 pose_;
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Zero();
  std::optional<MotionInput> input_;
  std::optional<BodyVelocity> velocity_;
};

}  // namespace hymm::core
