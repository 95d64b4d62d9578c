#include "ros/pose_conversions.h"

#include <array>
#include <cmath>

namespace hymm {
namespace {

constexpr std::array<std::size_t, 3> kPlanarAxes = {0, 1, 5};  // x, y, yaw of the six

}  // namespace

geometry_msgs::Quaternion quaternionFromYaw(double yaw_rad) {
  geometry_msgs::Quaternion quaternion;
  quaternion.z = std::sin(yaw_rad / 2.0);
  quaternion.w = std::cos(yaw_rad / 2.0);
  return quaternion;
}

double yawOf(const geometry_msgs::Quaternion& q) {
  return std::atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z));
}

geometry_msgs::Pose toPoseMessage(const core::Pose2& pose) {
  geometry_msgs::Pose message;
  message.position.x = pose.x_m;
  message.position.y = pose.y_m;
  message.orientation = quaternionFromYaw(pose.yaw_rad);
  return message;
}

geometry_msgs::Transform toTransformMessage(const core::Pose2& pose) {
  geometry_msgs::Transform message;
  message.translation.x = pose.x_m;
  message.translation.y = pose.y_m;
  message.rotation = quaternionFromYaw(pose.yaw_rad);
  return message;
}

core::Pose2 fromMessage(const geometry_msgs::Pose& message) {
  return {message.position.x, message.position.y, yawOf(message.orientation)};
}

core::Pose2 fromMessage(const geometry_msgs::Transform& message) {
  return {message.translation.x, message.translation.y, yawOf(message.rotation)};
}

geometry_msgs::PoseWithCovariance toMessage(const core::Pose2& pose,
                                            const Eigen::Matrix3d& covariance) {
  geometry_msgs::PoseWithCovariance message;
  message.pose = toPoseMessage(pose);
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      message.covariance[6 * kPlanarAxes[row] + kPlanarAxes[column]] =
          covariance(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column));
    }
  }
  return message;
}

Eigen::Matrix3d planarCovariance(const geometry_msgs::PoseWithCovariance& message) {
  Eigen::Matrix3d covariance;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      covariance(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) =
          message.covariance[6 * kPlanarAxes[row] + kPlanarAxes[column]];
    }
  }
  return covariance;
}

}  // namespace hymm
