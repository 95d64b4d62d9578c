#include "vehicle/sweep_motion.h"

#include <algorithm>

#include "vehicle/arc.h"

namespace hymm::core {
namespace {

Pose2 alongArc(const SweepMotion::Piece& piece, double duration_s) {
  const double turn = piece.yaw_rate_radps * duration_s;
  const Eigen::Vector2d moved =
      Arc(turn).V() * Eigen::Vector2d(piece.forward_mps, piece.lateral_mps) * duration_s;
  return {moved.x(), moved.y(), wrapAngle(turn)};
}

}  // namespace

Pose2 SweepMotion::poseAfter(double after_s) const {
  Pose2 pose;
  for (std::size_t i = 0; i < pieces.size() && pieces[i].from_s < after_s; ++i) {
    const double end_s = i + 1 < pieces.size() ? std::min(pieces[i + 1].from_s, after_s) : after_s;
    pose = pose * alongArc(pieces[i], end_s - pieces[i].from_s);
  }
  return pose;
}

Eigen::Matrix3d SweepMotion::covarianceAfter(double after_s) const {
  return after_s * after_s * velocity_covariance + after_s * white_density;
}

Pose2 SweepMotion::sensorPoseAfter(double after_s, const Pose2& T_base_sensor) const {
  return inverse(T_base_sensor) * (poseAfter(after_s) * T_base_sensor);
}

Eigen::Matrix3d SweepMotion::sensorCovarianceAfter(double after_s,
                                                   const Pose2& T_base_sensor) const {
  // A turn of base_link moves a sensor across the arm that carries it.
  Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
  J.topRightCorner<2, 1>() << -T_base_sensor.y_m, T_base_sensor.x_m;
  J.topRows<2>() = T_base_sensor.rotation().transpose() * J.topRows<2>().eval();
  return J * covarianceAfter(after_s) * J.transpose();
}

}  // namespace hymm::core
