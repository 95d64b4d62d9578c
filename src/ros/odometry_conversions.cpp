#include "ros/odometry_conversions.h"

#include "ros/pose_conversions.h"
#include "ros/time_conversions.h"

namespace hymm {
namespace {

geometry_msgs::TwistWithCovariance toMessage(const core::BodyVelocity& velocity,
                                             double correlation_time_s) {
  geometry_msgs::TwistWithCovariance message;
  message.twist.linear.x = velocity.forward_mps;
  message.twist.linear.y = velocity.lateral_mps;
  message.twist.angular.z = velocity.yaw_rate_radps;
  message.covariance =
      hymm::toMessage(core::Pose2{}, velocity.covariance(correlation_time_s)).covariance;
  return message;
}

}  // namespace

nav_msgs::Odometry odometryMessage(const core::DeadReckoning& dead_reckoning,
                                   const core::VehicleConfig& vehicle) {
  nav_msgs::Odometry message;
  message.header.stamp = toRosTime(dead_reckoning.time_s());
  message.header.frame_id = vehicle.odom_frame;
  message.child_frame_id = vehicle.base_frame;
  message.pose = toMessage(dead_reckoning.T_odom_base(), dead_reckoning.covariance());
  if (dead_reckoning.velocity()) {
    message.twist = toMessage(*dead_reckoning.velocity(), vehicle.noise.correlation_time_s);
  }
  return message;
}

geometry_msgs::TransformStamped odometryTransform(const core::DeadReckoning& dead_reckoning,
                                                  const core::VehicleConfig& vehicle) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = toRosTime(dead_reckoning.time_s());
  message.header.frame_id = vehicle.odom_frame;
  message.child_frame_id = vehicle.base_frame;
  message.transform = toTransformMessage(dead_reckoning.T_odom_base());
  return message;
}

}  // namespace hymm
