#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include <diagnostic_updater/diagnostic_updater.h>
#include <hymm/ExportMap.h>
#include <hymm/LoadState.h>
#include <hymm/MatchScan.h>
#include <hymm/Pause.h>
#include <hymm/QueryProperty.h>
#include <hymm/Reset.h>
#include <hymm/SaveState.h>
#include <nav_msgs/GetMap.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <ros/spinner.h>
#include <tf2_ros/buffer.h>

#include "pipeline/filter_life.h"
#include "pipeline/grid_files.h"
#include "pipeline/grid_mapper.h"
#include "ros/cause_log.h"
#include "ros/cloud_scans.h"
#include "ros/grid_output.h"
#include "ros/sample_placer.h"
#include "ros/scan_pairing.h"
#include "ros/sensor_mountings.h"
#include "ros/traffic_meter.h"
#include "ros/transform_reader.h"
#include "vehicle/vehicle_config.h"

namespace hymm {

/// The node `hymm_grid`: one thread receives messages, another brings together what belongs to a
/// scan, keeps the dense map in step with the filter and publishes; a third answers services and
/// new subscribers. What the map holds depends on stamps and versions, never on when messages
/// arrive.
class HymmGridNode {
 public:
  /// Throws ConfigError if the parameters are unusable.
  HymmGridNode(const core::HymmGridConfig& config, const core::VehicleConfig& vehicle,
               const core::PointCloudConfig& point_clouds);
  ~HymmGridNode();

 private:
  template <class Message>
  void subscribe(const std::string& topic);
  void take(const sensor_msgs::LaserScan::ConstPtr& message);
  void take(const sensor_msgs::PointCloud2::ConstPtr& message);
  void take(const FilterPose::ConstPtr& message);
  void take(const LandmarkUpdate::ConstPtr& message);
  void take(const LandmarkMap::ConstPtr& message);
  void take(const PropertySample::ConstPtr& message);

  void work();
  void workOn();
  std::optional<PairedScan> waitForScan();
  void pairClouds();
  void process(const PairedScan& paired);
  void tell(const core::MappedOutcome& outcome, const PairedScan& paired);
  void beginAnew(core::FilterCourse course);
  void placeSamples();
  void write(const core::PropertySample& sample);
  void publishIfDue();
  void disconnectStuckReaders();
  GridStatus status() const;

  void advertiseServices();
  bool getMap(nav_msgs::GetMap::Request& request, nav_msgs::GetMap::Response& response);
  bool queryProperty(QueryProperty::Request& request, QueryProperty::Response& response);
  bool exportMap(ExportMap::Request& request, ExportMap::Response& response);
  bool matchScan(MatchScan::Request& request, MatchScan::Response& response);
  bool pause(Pause::Request& request, Pause::Response& response);
  bool reset(Reset::Request& request, Reset::Response& response);
  bool saveState(SaveState::Request& request, SaveState::Response& response);
  void writeState(const SaveState::Request& request, SaveState::Response& response);
  bool isHeld();
  bool loadState(LoadState::Request& request, LoadState::Response& response);
  void install(const std::string& state, const std::string& name,
               const LoadState::Request& request);
  bool isOfMapBefore(const PairedScan& paired);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);
  void diagnoseScans(const GridStatus& grid,
                     diagnostic_updater::DiagnosticStatusWrapper& status) const;
  void diagnoseMap(const GridStatus& grid,
                   diagnostic_updater::DiagnosticStatusWrapper& status) const;

  core::HymmGridConfig config_;
  core::VehicleConfig vehicle_;
  ros::NodeHandle handle_, private_handle_{"~"};
  CauseLog causes_;
  TrafficMeter traffic_;
  tf2_ros::Buffer tf_;
  TransformReader transforms_;

  mutable std::mutex inputs_mutex_;  ///< over what callbacks fill
  std::condition_variable arrived_;
  ScanPairing pairing_;
  SensorMountings scan_places_;
  CloudScans clouds_;
  std::deque<PropertySample::ConstPtr> samples_;

  std::mutex mutex_;  ///< over everything down to output_; never with inputs_mutex_ inside out
  core::GridMapper mapper_;
  SamplePlacer sample_placer_;
  core::StampSchedule status_due_{1.0}, log_due_{core::kMemoryLogPeriod_s};
  core::FilterLife filter_;                      ///< by its poses
  std::optional<std::uint64_t> awaited_resets_;  ///< of the filter, since a map was loaded
  double awaited_until_s_ = 0.0;                 ///< by the wall
  std::uint64_t held_version_ = 0;  ///< while a map is saved: of the landmarks, to stop at
  double held_until_s_ = 0.0;       ///< by the wall
  std::optional<core::LaserScan> last_scan_;
  core::PoseEstimate last_pose_;
  ros::Time stamp_;  ///< of the last scan
  double agreement_;
  bool paused_ = false;
  double worst_latency_ms_ = 0.0;  ///< of a scan, since the last diagnosis
  double step_wall_s_ = 0.0;       ///< when the last scan was processed
  double publish_wall_s_ = 0.0;    ///< when changes were sent
  bool is_settled_ = true;         ///< the whole map was sent after the last scan
  ros::CallbackQueue calls_;       ///< of services and new subscribers
  GridOutput output_;

  std::vector<ros::Subscriber> subscribers_;
  std::vector<ros::ServiceServer> services_;
  ros::AsyncSpinner call_spinner_{1, &calls_};
  diagnostic_updater::Updater diagnostics_;
  ros::SteadyTimer diagnostics_timer_;
  std::atomic<bool> working_{true};
  std::thread worker_;
};

}  // namespace hymm
