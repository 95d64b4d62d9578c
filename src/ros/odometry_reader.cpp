#include "ros/odometry_reader.h"

#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "ros/pose_conversions.h"
#include "ros/sensor_conversions.h"

namespace hymm {
namespace {

constexpr double kFastest_mps = 100.0;  // what seems faster is a pose that was set anew

/// The constant velocity that leads along `moved` in `duration_s`. The chord points half the turn
/// ahead and is shorter than the arc by sin(t/2) / (t/2).
core::TwistInput velocityOf(const core::Pose2& moved, double begin_s, double duration_s) {
  const double half = 0.5 * moved.yaw_rad;
  const double stretch = std::abs(half) < 1e-6 ? 1.0 : half / std::sin(half);
  const Eigen::Vector2d arc = stretch * (Eigen::Rotation2Dd(-half) * moved.position()) / duration_s;
  return {begin_s, arc.x(), arc.y(), moved.yaw_rad / duration_s};
}

bool isZero(const core::TwistInput& twist) {
  return twist.forward_mps == 0.0 && twist.lateral_mps == 0.0 && twist.yaw_rate_radps == 0.0;
}

}  // namespace

std::optional<core::TwistInput> OdometryReader::read(const nav_msgs::Odometry& message,
                                                     CauseLog& causes) {
  const core::TwistInput twist = fromMessage(message);
  has_twist_ = has_twist_ || !isZero(twist);
  if (has_twist_) return twist;
  return readPose(message, causes);
}

std::optional<core::TwistInput> OdometryReader::readPose(const nav_msgs::Odometry& message,
                                                         CauseLog& causes) {
  const StampedPose now{message.header.stamp.toSec(), fromMessage(message.pose.pose)};
  if (!now.T_odom_base.vector().allFinite()) {
    causes.count("odometry refused",
                 "An odometry message has neither a twist nor a finite pose; it is not used.");
    return std::nullopt;
  }
  const std::optional<StampedPose> before = std::exchange(last_, now);
  if (!before || now.time_s <= before->time_s) return std::nullopt;
  const core::Pose2 moved = core::inverse(before->T_odom_base) * now.T_odom_base;
  const core::TwistInput velocity = velocityOf(moved, before->time_s, now.time_s - before->time_s);
  if (std::hypot(velocity.forward_mps, velocity.lateral_mps) > kFastest_mps) {
    causes.count("odometry set anew", "The pose of odometry jumps; that motion is not used.");
    return std::nullopt;
  }
  if (!isZero(velocity)) {
    causes.count("odometry without twist",
                 "The poses of odometry move but its twist is zero; poses are used for it.");
  }
  return velocity;
}

void OdometryReader::reset() {
  has_twist_ = false;
  last_.reset();
}

}  // namespace hymm
