#pragma once

#include <deque>
#include <optional>
#include <vector>

#include <diagnostic_updater/diagnostic_updater.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <hymm/FilterHealth.h>
#include <hymm/FilterPose.h>
#include <hymm/GridStatus.h>
#include <hymm/LandmarkMap.h>
#include <hymm/LandmarkUpdate.h>
#include <hymm/SetMode.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <sensor_msgs/NavSatFix.h>
#include <tf2_ros/buffer.h>

#include "common/serial_worker.h"
#include "pipeline/landmark_mirror.h"
#include "ros/cause_log.h"
#include "ros/filter_pairing.h"
#include "ros/gps_overlay.h"
#include "ros/map_odom_broadcaster.h"
#include "ros/relocaliser_watch.h"
#include "ros/traffic_meter.h"
#include "ros/trajectory_path.h"
#include "ros/transform_reader.h"
#include "ros/transform_watch.h"
#include "supervisor/grid_agreement.h"
#include "supervisor/supervisor_decision.h"

namespace hymm {

/// The node `supervisor`: decides which filter is in charge, and owns `pose`, `filter_status`,
/// `trajectory` and tf map -> odom. A scan is decided on when all that concerns it has come, so
/// that decisions depend on stamps, not on when messages arrive.
class SupervisorNode {
 public:
  /// `filter`: the parameters of cekf_slam, for what it takes observations from.
  SupervisorNode(const core::SupervisorConfig& config, const core::CekfSlamConfig& filter,
                 const core::VehicleConfig& vehicle);

 private:
  void subscribe();
  void takePose(const FilterPose& message);
  void takeHealth(const FilterHealth& message);
  void takeMap(const LandmarkMap& message);
  void takeUpdate(const LandmarkUpdate& message);
  void takeGridStatus(const GridStatus& message);
  bool setMode(SetMode::Request& request, SetMode::Response& response);
  void pairAnswers();
  void processAnswers();
  bool endsSearch(const FilterAnswer& answer) const;
  bool isComplete(const FilterAnswer& answer, double since_s) const;
  void process(const FilterAnswer& answer);
  void publishPose(const FilterAnswer& answer);
  void noteRestart();
  void takeOdometry(const nav_msgs::Odometry& message);
  void takeGps(const sensor_msgs::NavSatFix& message);
  void tick();
  void publishPaths();
  void decide(const ros::Time& stamp);
  void act();
  void publishStatus(const core::SupervisorDecision& decision, const ros::Time& stamp);
  void beginRecording();
  void beginMap();
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  core::SupervisorConfig config_;
  bool of_detections_;
  core::SupervisorDecision decision_;
  core::SupervisorEvidence evidence_;
  FilterPairing pairing_;
  struct Waiting {
    FilterAnswer answer;
    double since_s;  ///< by the wall
  };
  std::deque<Waiting> answers_;  ///< not decided on yet
  core::LandmarkMirror landmarks_;
  core::GridAgreement agreement_;
  core::OldLandmarkWatch old_landmarks_;
  /// Number of the order before the first. Orders of one that was started anew go on by the clock,
  /// so that the relocaliser takes none for one that it has obeyed.
  std::uint64_t first_order_;
  std::uint64_t orders_;  ///< to the relocaliser: the last one's number
  CauseLog causes_;
  TrafficMeter traffic_;
  double worst_latency_ms_ = 0.0;  ///< since the last diagnosis
  bool status_sent_ = false;
  std::optional<double> pose_wall_s_;
  ros::Time pose_stamp_;
  core::FilterLife filter_;             ///< by its answers
  std::uint32_t filter_landmarks_ = 0;  ///< that it had at the last one
  std::string lost_;                    ///< what went with a filter that was started anew
  std::size_t poses_ = 0;
  std::size_t mode_switches_ = 0;
  double trajectory_sent_s_ = 0.0;
  std::size_t trajectory_sent_poses_ = 0;

  ros::NodeHandle handle_;
  tf2_ros::Buffer tf_;
  TransformReader transforms_;
  RelocaliserWatch relocaliser_;
  MapOdomBroadcaster map_odom_;
  TransformWatch watch_;
  TrajectoryPath trajectory_;
  TrajectoryPath dead_reckoning_;  ///< odometry alone, from the map's origin, to compare with
  std::optional<core::Pose2> T_odom_first_;
  GpsOverlay gps_;
  ros::Publisher pose_publisher_, status_publisher_, trajectory_publisher_,
      dead_reckoning_publisher_, gps_publisher_;
  std::vector<ros::Subscriber> subscribers_;
  ros::ServiceServer set_mode_service_;
  diagnostic_updater::Updater diagnostics_;
  ros::SteadyTimer timer_, diagnostics_timer_;
  core::SerialWorker calls_{core::SerialWorker::Mode::kBackground};  ///< of services
};

}  // namespace hymm
