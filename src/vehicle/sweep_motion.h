#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/pose2.h"

namespace hymm::core {

/// How base_link moves after the stamp of a scan whose beams are measured one after another: pieces
/// of constant velocity. Without pieces it stands still.
struct SweepMotion {
  struct Piece {
    double from_s = 0.0;  ///< after the stamp; up to the next piece
    double forward_mps = 0.0;
    double lateral_mps = 0.0;
    double yaw_rate_radps = 0.0;
  };
  std::vector<Piece> pieces;  ///< in their order, the first from the stamp on

  /// Of the velocity (forward, lateral, yaw rate) at the stamp, whose error persists.
  Eigen::Matrix3d velocity_covariance = Eigen::Matrix3d::Zero();
  /// Of the velocity's white noise, (unit)^2 * s.
  Eigen::Matrix3d white_density = Eigen::Matrix3d::Zero();

  bool isStill() const { return pieces.empty(); }

  /// T_stamp_base: where base_link is `after_s` >= 0 after the stamp, from where it was then.
  Pose2 poseAfter(double after_s) const;
  /// Covariance of that pose, axes of base_link.
  Eigen::Matrix3d covarianceAfter(double after_s) const;

  /// The same of a sensor, from where the sensor was at the stamp, in its own axes.
  Pose2 sensorPoseAfter(double after_s, const Pose2& T_base_sensor) const;
  Eigen::Matrix3d sensorCovarianceAfter(double after_s, const Pose2& T_base_sensor) const;
};

}  // namespace hymm::core
