#include "ros/map_odom_broadcaster.h"

#include <algorithm>

#include "ros/pose_conversions.h"
#include "ros/transform_lookup.h"

namespace hymm {

MapOdomBroadcaster::MapOdomBroadcaster(const tf2_ros::Buffer& tf,
                                       const core::VehicleConfig& vehicle, double wait_s)
    : vehicle_(vehicle),
      correction_([&tf, odom = vehicle.odom_frame, base = vehicle.base_frame](
                      const ros::Time& stamp) { return findTransform(tf, odom, base, stamp); },
                  wait_s) {}

void MapOdomBroadcaster::setPose(const ros::Time& stamp, const core::Pose2& T_map_base,
                                 double steady_now_s) {
  correction_.setPose(stamp, T_map_base, steady_now_s);
}

void MapOdomBroadcaster::broadcast(const ros::Time& now, double steady_now_s) {
  correction_.update(steady_now_s);
  if (!correction_.T_map_odom()) return;
  const ros::Time stamp = std::max(now, correction_.pose_stamp());
  if (stamp <= sent_stamp_) return;  // a paused clock; tf complains of repeated stamps
  geometry_msgs::TransformStamped message;
  message.header.stamp = sent_stamp_ = stamp;
  message.header.frame_id = vehicle_.map_frame;
  message.child_frame_id = vehicle_.odom_frame;
  message.transform = toTransformMessage(*correction_.T_map_odom());
  broadcaster_.sendTransform(message);
}

void MapOdomBroadcaster::reset() {
  correction_.reset();
  sent_stamp_ = ros::Time();
}

std::string MapOdomBroadcaster::problem() const {
  if (!correction_.problem()) return "";
  return "tf has no '" + vehicle_.odom_frame + "' -> '" + vehicle_.base_frame +
         "' at the scan's time; start dead_reckoning, or let the robot publish it. (" +
         *correction_.problem() + ")";
}

}  // namespace hymm
