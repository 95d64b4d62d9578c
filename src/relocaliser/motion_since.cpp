#include "relocaliser/motion_since.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace hymm::core {
namespace {

MotionInput standing(double time_s) { return TwistInput{time_s, 0.0, 0.0, 0.0, std::nullopt}; }

}  // namespace

MotionSince::MotionSince(const VehicleConfig& vehicle, const Calibration& calibration)
    : model_(vehicle), calibration_(calibration) {}

void MotionSince::begin(double time_s) {
  time_s_ = time_s;
  pose_ = {};
  covariance_.setZero();
}

bool MotionSince::process(const MotionInput& input) {
  if (!isFinite(input) || (input_ && timeOf(input) <= timeOf(*input_))) return false;
  if (time_s_) moveTo(timeOf(input));
  input_ = input;
  return true;
}

void MotionSince::advance(double time_s) { moveTo(time_s); }

void MotionSince::moveTo(double time_s) {
  const double duration_s = time_s - time_s_.value_or(time_s);
  if (duration_s <= 0.0) return;
  const MotionInput input = input_.value_or(standing(*time_s_));
  const double age_s = std::max(0.0, *time_s_ - timeOf(input));
  const MotionStep step = model_.step(pose_, input, calibration_, age_s, duration_s);
  covariance_ = step.J_pose * covariance_ * step.J_pose.transpose() + step.noise;
  pose_ = step.pose;
  time_s_ = time_s;
}

NoisyStep MotionSince::step() const {
  // A vehicle at rest has no noise at all in some directions.
  const Eigen::Matrix3d P = covariance_ + 1e-12 * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d root = P.llt().matrixL();
  return {pose_.vector().cast<float>(), root.cast<float>()};
}

Eigen::Vector3d MotionSince::deviationOfOneSecond() const {
  const MotionInput input = input_.value_or(standing(0.0));
  constexpr double kSecond_s = 1.0;
  return model_.step({}, input, calibration_, 0.0, kSecond_s)
      .noise.diagonal()
      .cwiseMax(0.0)
      .cwiseSqrt();
}

}  // namespace hymm::core
