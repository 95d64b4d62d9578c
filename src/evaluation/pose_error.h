#pragma once

#include <optional>
#include <vector>

#include "evaluation/error_statistics.h"
#include "evaluation/trajectory.h"

namespace hymm::core {

/// An estimated pose and its covariance of (x [m], y [m], yaw [rad]) in map axes.
struct UncertainPose {
  StampedPose pose;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// How far estimated poses lie from true ones.
struct PoseErrors {
  ErrorStatistics position_m;          ///< as they are: both in the same frame
  ErrorStatistics aligned_position_m;  ///< after one rigid motion of the plane
  Pose2 T_truth_map;                   ///< that motion, of the estimate onto the truth
  double heading_rmse_rad = 0.0;       ///< as they are
  Consistency nees;                    ///< of the pose as it is, three degrees of freedom
  std::size_t without_truth = 0;       ///< poses of the window at whose time there is no truth
};

/// Compares the poses of the window with the truth, interpolated at their times. Poses whose
/// covariance is not positive definite, as the first of a map, are left out of the NEES. Nothing
/// without a pose to compare.
std::optional<PoseErrors> computePoseErrors(const std::vector<UncertainPose>& poses,
                                            const Trajectory& truth, const TimeWindow& window);

/// A truth that is given in a frame of its own, in the map's frame.
Trajectory inFrameOf(const Pose2& T_world_map, const Trajectory& truth);

}  // namespace hymm::core
