#pragma once

#include <vector>

#include <Eigen/Core>

#include "cekf/compressed_ekf.h"

namespace hymm::core {

/// How uncertain a vehicle's pose is relative to landmarks, not to the origin of map: the
/// covariance of (x, y, yaw) [m, rad], in map axes, of its error less the rigid motion (shift and
/// turn, least squares) of the landmarks' errors. What all of them have in common does no harm to a
/// map that hangs on the landmarks (paper, III).
///
/// `joint`: covariance of the pose and then of each landmark's (x, y). A single landmark (or
/// several in one place) tells of no turn: the heading then counts as it is. Without landmarks, so
/// does everything.
Eigen::Matrix3d relativeCovariance(const Eigen::Vector2d& position,
                                   const std::vector<Eigen::Vector2d>& landmarks,
                                   const Eigen::MatrixXd& joint);

/// The same for a filter's vehicle. The landmarks are those `seen` (slots, all active), at most
/// twelve, the nearest first; if fewer than two were seen, the nearest active ones.
Eigen::Matrix3d relativeCovariance(const CompressedEkf& filter, const std::vector<int>& seen);

}  // namespace hymm::core
