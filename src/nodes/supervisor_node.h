#pragma once

#include <optional>

#include <diagnostic_updater/diagnostic_updater.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <hymm/FilterHealth.h>
#include <hymm/FilterPose.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <sensor_msgs/NavSatFix.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include "ros/cause_log.h"
#include "ros/filter_pairing.h"
#include "ros/gps_overlay.h"
#include "ros/map_odom_broadcaster.h"
#include "ros/trajectory_path.h"
#include "ros/transform_watch.h"
#include "supervisor/supervisor_decision.h"

namespace hymm {

/// The node `supervisor`: decides which filter is in charge, and owns `pose`, `filter_status`,
/// `trajectory` and tf map -> odom.
class SupervisorNode {
 public:
  SupervisorNode(const core::SupervisorConfig& config, const core::VehicleConfig& vehicle);

 private:
  void takePose(const FilterPose& message);
  void takeHealth(const FilterHealth& message);
  void processPairs();
  void process(const FilterAnswer& answer);
  void takeOdometry(const nav_msgs::Odometry& message);
  void takeGps(const sensor_msgs::NavSatFix& message);
  void takeInitialPose(const geometry_msgs::PoseWithCovarianceStamped& message);
  void tick();
  void publishPaths();
  void decide(const ros::Time& stamp);
  void publishStatus(const core::SupervisorDecision& decision, const ros::Time& stamp);
  void beginRecording();
  void beginMap();
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  core::SupervisorConfig config_;
  core::SupervisorDecision decision_;
  core::SupervisorEvidence evidence_;
  FilterPairing pairing_;
  CauseLog causes_;
  bool status_sent_ = false;
  std::optional<double> pose_wall_s_;
  ros::Time pose_stamp_;
  std::optional<std::uint64_t> resets_;  ///< of the filter, as of its last health
  std::size_t poses_ = 0;
  std::size_t initial_poses_refused_ = 0;
  double trajectory_sent_s_ = 0.0;
  std::size_t trajectory_sent_poses_ = 0;

  ros::NodeHandle handle_;
  tf2_ros::Buffer tf_;
  tf2_ros::TransformListener tf_listener_;
  MapOdomBroadcaster map_odom_;
  TransformWatch watch_;
  TrajectoryPath trajectory_;
  TrajectoryPath dead_reckoning_;  ///< odometry alone, from the map's origin, to compare with
  std::optional<core::Pose2> T_odom_first_;
  GpsOverlay gps_;
  ros::Publisher pose_publisher_, status_publisher_, trajectory_publisher_,
      dead_reckoning_publisher_, gps_publisher_;
  ros::Subscriber pose_subscriber_, health_subscriber_, odometry_subscriber_, gps_subscriber_,
      initial_pose_subscriber_;
  diagnostic_updater::Updater diagnostics_;
  ros::SteadyTimer timer_, diagnostics_timer_;
};

}  // namespace hymm
