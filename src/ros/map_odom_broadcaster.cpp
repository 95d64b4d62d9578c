#include "ros/map_odom_broadcaster.h"

#include <algorithm>

#include "ros/pose_conversions.h"
#include "ros/transform_lookup.h"

namespace hymm {

MapOdomBroadcaster::MapOdomBroadcaster(const tf2_ros::Buffer& tf,
                                       const core::VehicleConfig& vehicle, double wait_s)
    : tf_(tf), vehicle_(vehicle), wait_s_(wait_s) {}

void MapOdomBroadcaster::setPose(const ros::Time& stamp, const core::Pose2& T_map_base,
                                 double steady_now_s) {
  const double since_s = pending_ ? pending_->since_s : steady_now_s;
  pending_ = Pose{stamp, T_map_base, since_s};
  tryUpdate(steady_now_s);
}

void MapOdomBroadcaster::tryUpdate(double steady_now_s) {
  if (!pending_) return;
  const TransformAnswer odometry =
      findTransform(tf_, vehicle_.odom_frame, vehicle_.base_frame, pending_->stamp);
  if (odometry.transform) {
    T_map_odom_ = pending_->T_map_base * core::inverse(fromMessage(odometry.transform->transform));
    pose_stamp_ = pending_->stamp;
    pending_.reset();
    problem_.clear();
  } else if (steady_now_s - pending_->since_s >= wait_s_) {
    problem_ = "tf has no '" + vehicle_.odom_frame + "' -> '" + vehicle_.base_frame +
               "' at the scan's time; start dead_reckoning, or let the robot publish it. (" +
               odometry.problem + ")";
  }
}

void MapOdomBroadcaster::broadcast(const ros::Time& now, double steady_now_s) {
  tryUpdate(steady_now_s);
  if (!T_map_odom_) return;
  const ros::Time stamp = std::max(now, pose_stamp_);
  if (stamp <= sent_stamp_) return;  // a paused clock; tf complains of repeated stamps
  geometry_msgs::TransformStamped message;
  message.header.stamp = sent_stamp_ = stamp;
  message.header.frame_id = vehicle_.map_frame;
  message.child_frame_id = vehicle_.odom_frame;
  message.transform = toTransformMessage(*T_map_odom_);
  broadcaster_.sendTransform(message);
}

void MapOdomBroadcaster::reset() {
  pending_.reset();
  T_map_odom_.reset();
  pose_stamp_ = sent_stamp_ = ros::Time();
  problem_.clear();
}

}  // namespace hymm
