#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <hymm/DeadReckoning.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <tf2_ros/transform_broadcaster.h>

#include "common/config.h"
#include "common/jump_filter.h"
#include "ros/cause_log.h"
#include "ros/traffic_meter.h"
#include "vehicle/dead_reckoning.h"
#include "vehicle/dead_reckoning_config.h"

namespace hymm {

/// The node `dead_reckoning`: integrates speed and steering into `odom` and tf odom -> base_link.
class DeadReckoningNode {
 public:
  DeadReckoningNode(const core::DeadReckoningConfig& config, const core::VehicleConfig& vehicle);

 private:
  struct Stamped {
    double time_s;
    DeadReckoning message;
  };

  void take(const DeadReckoning& message);
  void process(const DeadReckoning& message);
  void publish(const ros::Time& stamp);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  core::DeadReckoningConfig config_;
  core::VehicleConfig vehicle_;
  core::DeadReckoning dead_reckoning_;
  CauseLog causes_;
  TrafficMeter traffic_;
  core::JumpFilter<Stamped> jump_filter_;
  std::size_t jumps_ = 0;

  ros::NodeHandle handle_;
  ros::Publisher publisher_;
  tf2_ros::TransformBroadcaster broadcaster_;
  ros::Subscriber subscriber_;
  diagnostic_updater::Updater diagnostics_;
  ros::SteadyTimer diagnostics_timer_;
};

}  // namespace hymm
