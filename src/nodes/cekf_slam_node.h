#pragma once

#include <atomic>
#include <mutex>
#include <thread>

#include <diagnostic_updater/diagnostic_updater.h>
#include <hymm/GetJointCovariance.h>
#include <hymm/LoadState.h>
#include <hymm/LtrMap.h>
#include <hymm/Pause.h>
#include <hymm/Reset.h>
#include <hymm/Resume.h>
#include <hymm/SaveState.h>
#include <hymm/Suspend.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <ros/spinner.h>
#include <tf2_ros/buffer.h>

#include "cekf/cekf_slam.h"
#include "pipeline/sensor_merger.h"
#include "ros/cause_log.h"
#include "ros/event_reader.h"
#include "ros/filter_output.h"
#include "ros/parameters.h"
#include "ros/scan_headers.h"
#include "ros/sensor_inputs.h"
#include "ros/sensor_queue.h"
#include "ros/transform_reader.h"
#include "storage/saved_settings.h"

namespace hymm {

/// The node `cekf_slam`: one thread receives messages and answers services, another merges them by
/// stamp, feeds the filter and publishes; a third answers what takes its time. Results depend on
/// stamps, never on when messages arrive.
class CekfSlamNode {
 public:
  /// Throws ConfigError if the parameters are unusable.
  CekfSlamNode(const core::CekfSlamConfig& config, const core::VehicleDescription& vehicle,
               const core::PointCloudConfig& point_clouds);
  ~CekfSlamNode();

 private:
  void work();
  void workOn();
  void readBacklog();
  void take(const SensorMessage& message, core::SensorEvent event, double now_s);
  void process(const core::SensorEvent& event);
  void finish(const core::ScanOutcome& outcome);
  void forgetRecording();
  std::size_t droppedScans() const;

  void takeLtrs(const LtrMap& message);
  bool pause(Pause::Request& request, Pause::Response& response);
  bool reset(Reset::Request& request, Reset::Response& response);
  void advertisePatiently();
  bool getJointCovariance(GetJointCovariance::Request& request,
                          GetJointCovariance::Response& response);
  bool suspend(Suspend::Request& request, Suspend::Response& response);
  bool resume(Resume::Request& request, Resume::Response& response);
  void advertiseStorage();
  bool saveState(SaveState::Request& request, SaveState::Response& response);
  bool loadState(LoadState::Request& request, LoadState::Response& response);
  void install(const std::string& state, const std::string& name, bool localise_only);
  void diagnoseInputs(diagnostic_updater::DiagnosticStatusWrapper& status);
  void diagnoseFilter(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle handle_;
  std::string map_frame_;
  core::SavedSettings settings_;
  CauseLog causes_;
  tf2_ros::Buffer tf_;
  TransformReader transforms_;

  std::mutex mutex_;  ///< over everything down to output_
  core::CekfSlam filter_;
  core::SensorMerger merger_;
  EventReader reader_;
  FilterOutput output_;
  std::deque<SensorMessage> backlog_;  ///< taken from the queue, not yet read
  ScanHeaders scan_headers_;
  bool paused_ = false;
  std::size_t unreadable_scans_ = 0;  ///< without a stamp, of an unknown frame, no scan at all
  double last_scan_wall_s_ = 0.0;
  double worst_latency_ms_ = 0.0;  ///< since the last diagnosis
  core::FilterHealth health_;

  SensorQueue queue_;
  SensorInputs inputs_;
  ros::Subscriber ltrs_subscriber_;
  ros::ServiceServer pause_service_, reset_service_;
  ros::CallbackQueue patient_calls_;  ///< services that may wait long, apart from the messages
  std::vector<ros::ServiceServer> patient_services_;
  std::vector<ros::ServiceServer> storage_services_;
  ros::AsyncSpinner patient_spinner_{1, &patient_calls_};
  diagnostic_updater::Updater diagnostics_;
  ros::SteadyTimer diagnostics_timer_;
  std::atomic<bool> working_{true};
  std::thread worker_;
};

}  // namespace hymm
