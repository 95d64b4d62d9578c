#include "ros/odometry_reader.h"

#include <cmath>

#include <Eigen/Geometry>

#include "ros/transform_lookup.h"

namespace hymm {
namespace {

/// Components that do not matter to a planar vehicle may be left unfilled; then they are 0.
double ifFinite(double value) { return std::isfinite(value) ? value : 0.0; }

Eigen::Vector3d linear(const geometry_msgs::Twist& twist) {
  return {twist.linear.x, twist.linear.y, ifFinite(twist.linear.z)};
}

Eigen::Vector3d angular(const geometry_msgs::Twist& twist) {
  return {ifFinite(twist.angular.x), ifFinite(twist.angular.y), twist.angular.z};
}

Eigen::Isometry3d isometryOf(const geometry_msgs::Pose& pose) {
  Eigen::Quaterniond q(pose.orientation.w, pose.orientation.x, pose.orientation.y,
                       pose.orientation.z);
  // Messages that nobody filled in have an orientation of zeros.
  q = q.norm() == 0.0 ? Eigen::Quaterniond::Identity() : q.normalized();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = q.toRotationMatrix();
  T.translation() << pose.position.x, pose.position.y, pose.position.z;
  return T;
}

/// Its yaw is that of its x axis in the plane.
core::Pose2 planar(const Eigen::Isometry3d& T) {
  const Eigen::Matrix3d R = T.linear();
  return {T.translation().x(), T.translation().y(), std::atan2(R(1, 0), R(0, 0))};
}

/// What the message tells of base_link, whose frame `T_base_child` places it in.
OdometryReading readingOf(const nav_msgs::Odometry& message,
                          const Eigen::Isometry3d& T_base_child) {
  OdometryReading reading;
  reading.time_s = message.header.stamp.toSec();
  const core::Pose2 T_odom_base = planar(isometryOf(message.pose.pose) * T_base_child.inverse());
  if (T_odom_base.vector().allFinite()) reading.T_odom_base = T_odom_base;

  const Eigen::Matrix3d R = T_base_child.linear();
  const Eigen::Vector3d turn = R * angular(message.twist.twist);
  const Eigen::Vector3d velocity =
      R * linear(message.twist.twist) - turn.cross(T_base_child.translation());
  const Eigen::Vector3d twist(velocity.x(), velocity.y(), turn.z());
  if (twist.allFinite()) reading.twist = twist;
  return reading;
}

}  // namespace

OdometryReader::Answer OdometryReader::read(const nav_msgs::Odometry& message,
                                            SensorMountings& mountings, double steady_now_s,
                                            CauseLog& causes) {
  const std::string child = withoutSlash(message.child_frame_id);
  Eigen::Isometry3d T_base_child = Eigen::Isometry3d::Identity();
  if (!child.empty() && child != withoutSlash(mountings.baseFrame())) {
    const SensorMountings::Answer mounting = mountings.findInSpace(child, steady_now_s);
    if (mounting.waiting) return {std::nullopt, true};
    if (mounting.T_base_sensor) T_base_child = mounting.T_base_frame;
    if (!mounting.problem.empty()) {
      causes.count("odometry of frame '" + child + "', taken for the vehicle's own",
                   "Odometry tells of frame '" + child + "' (child_frame_id): " + mounting.problem +
                       ". Until then it is taken to tell of '" + mountings.baseFrame() + "'.");
    }
  }
  return {motion_.take(readingOf(message, T_base_child), causes), false};
}

}  // namespace hymm
