#pragma once

#include <Eigen/Core>

#include "cekf/landmark_map.h"
#include "common/pose2.h"

namespace hymm::core {

/// Where the vehicle may be, as a Gaussian in some frame.
struct PosePrior {
  Pose2 mean;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x [m], y [m], yaw [rad])
};

/// Landmarks and the vehicle among them, jointly, as the filter has them at one moment (map frame).
struct VehicleAmongLandmarks {
  JointLandmarks landmarks;  ///< its time and version are those of the vehicle, too
  PosePrior vehicle;
  /// Covariance of the pose (3 rows) with the landmarks (2 columns each); empty: independent.
  Eigen::MatrixXd cross_covariance;
};

}  // namespace hymm::core
