#pragma once

#include <string>

#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_broadcaster.h>

#include "common/pose2.h"
#include "ros/odom_correction.h"
#include "vehicle/vehicle_config.h"

namespace hymm {

/// Broadcasts map -> odom, so that map -> base_link is the filter's pose at the pose's stamp and
/// moves on with the odometry after it.
class MapOdomBroadcaster {
 public:
  MapOdomBroadcaster(const tf2_ros::Buffer& tf, const core::VehicleConfig& vehicle, double wait_s);

  /// The filter's pose at `stamp`. Odometry of that time may come later.
  void setPose(const ros::Time& stamp, const core::Pose2& T_map_base, double steady_now_s);

  /// Sends the transform as of `now`, if it is known and `now` is later than what was sent.
  void broadcast(const ros::Time& now, double steady_now_s);

  /// Another recording begins.
  void reset();

  /// Why map -> odom does not follow the filter; empty if it does.
  std::string problem() const;

 private:
  core::VehicleConfig vehicle_;
  OdomCorrection correction_;
  ros::Time sent_stamp_;
  tf2_ros::TransformBroadcaster broadcaster_;
};

}  // namespace hymm
