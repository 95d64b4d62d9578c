#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include <diagnostic_updater/diagnostic_updater.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <hymm/DeadReckoning.h>
#include <hymm/FilterPose.h>
#include <hymm/FilterStatus.h>
#include <hymm/LandmarkMap.h>
#include <hymm/LandmarkObservations.h>
#include <hymm/LandmarkUpdate.h>
#include <hymm/RelocaliserHealth.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <std_srvs/Empty.h>
#include <tf2_ros/buffer.h>

#include "cekf/cekf_slam_config.h"
#include "pipeline/landmark_mirror.h"
#include "pipeline/sensor_merger.h"
#include "relocaliser/relocalisation.h"
#include "ros/cause_log.h"
#include "ros/filter_service_link.h"
#include "ros/odometry_reader.h"
#include "ros/sensor_mountings.h"
#include "ros/traffic_meter.h"
#include "ros/transform_reader.h"
#include "ros/wish_numbers.h"
#include "vehicle/vehicle_config.h"

namespace hymm {

/// The node `relocaliser`: one thread receives messages, another merges them by stamp, searches,
/// asks the filter and publishes. It searches when the supervisor tells it to, in `filter_status`.
class RelocaliserNode {
 public:
  /// `filter`: the parameters of cekf_slam, for its motion input and its merging.
  RelocaliserNode(const core::RelocaliserConfig& config, const core::CekfSlamConfig& filter,
                  const core::VehicleConfig& vehicle);
  ~RelocaliserNode();

 private:
  using Command = std::variant<core::SearchWish, FilterStatus>;

  void subscribe(const std::string& motion_input);
  void takeDeadReckoning(const DeadReckoning& message);
  void takeOdometry(const nav_msgs::Odometry& message);
  void takeMotion(const core::MotionInput& input);
  void takeObservations(const LandmarkObservations& message);
  void takePose(const FilterPose& message);
  void takeMap(const LandmarkMap& message);
  void takeUpdate(const LandmarkUpdate& message);
  void takeStatus(const FilterStatus& message);
  void takeInitialPose(const geometry_msgs::PoseWithCovarianceStamped& message);
  bool localiseGlobally(std_srvs::Empty::Request& request, std_srvs::Empty::Response& response);
  void pairObservations();
  void order(Command command);

  void work();
  void workOn();
  bool search();
  void process(const core::SensorEvent& event);
  void processScan(const core::ObservationSet& set);
  void obey(const Command& command);
  void obey(const FilterStatus& status);
  void publish(const core::SearchReport& report);
  void publishHealth();
  void diagnoseInputs(diagnostic_updater::DiagnosticStatusWrapper& status);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  std::string map_frame_;
  ros::NodeHandle handle_;
  CauseLog causes_;
  tf2_ros::Buffer tf_;
  TransformReader transforms_;
  SensorMountings mountings_;
  OdometryReader odometry_;
  TrafficMeter traffic_;

  std::mutex inputs_mutex_;  ///< over everything down to commands_
  std::condition_variable arrived_;
  core::SensorMerger merger_;
  std::map<ros::Time, core::ObservationSet> sets_;  ///< without their poses yet
  std::map<ros::Time, FilterPose> poses_;           ///< without their sets yet
  std::map<double, FilterPose> paired_poses_;       ///< of what is in the merger
  std::deque<Command> commands_;

  // The worker's own.
  FilterServiceLink link_;
  core::Relocalisation relocalisation_;
  core::FilterLife filter_;  ///< by its poses
  std::uint64_t last_order_ = 0;
  WishNumbers wishes_;
  double worked_s_ = 0.0;  ///< by the wall, since the last report

  std::mutex health_mutex_;  ///< over health_
  RelocaliserHealth health_;

  ros::Publisher pose_publisher_, health_publisher_, particles_publisher_;
  std::vector<ros::Subscriber> subscribers_;
  ros::ServiceServer global_service_;
  diagnostic_updater::Updater diagnostics_;
  ros::SteadyTimer heartbeat_, diagnostics_timer_;
  std::atomic<bool> working_{true};
  std::thread worker_;
};

}  // namespace hymm
