#pragma once

#include <optional>

#include "relocaliser/particle_kernels.h"
#include "vehicle/motion_model.h"

namespace hymm::core {

/// Collects motion inputs between scans into one step of motion, with its noise, in the axes of the
/// vehicle at the first of them. Each input holds until the next.
class MotionSince {
 public:
  MotionSince(const VehicleConfig& vehicle, const Calibration& calibration);

  /// Begins at `time_s`; the input in force stays.
  void begin(double time_s);
  /// False, and nothing changes, for an input that is not finite or not later than the last.
  bool process(const MotionInput& input);
  /// The motion from begin() to `time_s`, and begins anew there. Without any input yet the vehicle
  /// is taken to stand, with the noise of a gap.
  void advance(double time_s);

  const Pose2& T_begin_end() const { return pose_; }
  const Eigen::Matrix3d& covariance() const { return covariance_; }
  NoisyStep step() const;

  /// Standard deviation of what the motion's noise adds in one second as the vehicle moves now:
  /// (x [m], y [m], yaw [rad]) in its own axes (A.4).
  Eigen::Vector3d deviationOfOneSecond() const;

 private:
  void moveTo(double time_s);

  MotionModel model_;
  Calibration calibration_;
  std::optional<MotionInput> input_;
  std::optional<double> time_s_;
  Pose2 pose_;
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Zero();
};

}  // namespace hymm::core
