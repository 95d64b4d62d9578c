#pragma once

#include <Eigen/Core>
#include <geometry_msgs/Pose.h>
#include <geometry_msgs/PoseWithCovariance.h>
#include <geometry_msgs/Transform.h>

#include "common/pose2.h"

/// Planar poses to messages and back. Messages carry z = 0; going back, roll and pitch are lost.
namespace hymm {

geometry_msgs::Quaternion quaternionFromYaw(double yaw_rad);
double yawOf(const geometry_msgs::Quaternion& quaternion);

geometry_msgs::Pose toPoseMessage(const core::Pose2& pose);
geometry_msgs::Transform toTransformMessage(const core::Pose2& pose);
core::Pose2 fromMessage(const geometry_msgs::Pose& message);
core::Pose2 fromMessage(const geometry_msgs::Transform& message);

/// Covariance of (x, y, yaw) in the places that a 6x6 covariance of (x, y, z, roll, pitch, yaw)
/// has for them; the rest is 0.
geometry_msgs::PoseWithCovariance toMessage(const core::Pose2& pose,
                                            const Eigen::Matrix3d& covariance);
Eigen::Matrix3d planarCovariance(const geometry_msgs::PoseWithCovariance& message);

}  // namespace hymm
