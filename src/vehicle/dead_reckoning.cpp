#include "vehicle/dead_reckoning.h"

namespace hymm::core {

DeadReckoning::DeadReckoning(const VehicleConfig& vehicle) : model_(vehicle) {}

bool DeadReckoning::process(const MotionInput& input) {
  if (!isFinite(input)) return false;
  if (input_) {
    const double duration_s = timeOf(input) - timeOf(*input_);
    if (duration_s <= 0.0) return false;
    const MotionStep step = model_.step(pose_, *input_, Calibration{}, 0.0, duration_s);
    pose_ = step.pose;
    covariance_ = step.J_pose * covariance_ * step.J_pose.transpose() + step.noise;
  }
  input_ = input;
  velocity_ = model_.velocity(input, Calibration{});
  return true;
}

void DeadReckoning::reset() {
  pose_ = Pose2{};
  covariance_.setZero();
  input_.reset();
  velocity_.reset();
}

}  // namespace hymm::core
