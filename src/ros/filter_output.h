#pragma once

#include <atomic>
#include <memory>
#include <string>

#include <hymm/FilterHealth.h>
#include <ros/node_handle.h>

#include "cekf/cekf_slam.h"
#include "cekf/map_schedule.h"

namespace hymm {

/// Publishes what the filter `cekf_slam` knows after each scan. Everything is decided by stamps, so
/// that a playback publishes the same messages each time.
class FilterOutput {
 public:
  FilterOutput(ros::NodeHandle handle, const core::CekfSlamConfig& config, std::string map_frame);

  /// After an accepted scan. `scan`: header of the message it came in; its stamp is passed on as it
  /// is, for whoever pairs the scan with the pose. `dropped_scans`: that did not reach
  /// the filter so far.
  void publish(core::CekfSlam& filter, const core::ScanOutcome& outcome,
               const std_msgs::Header& scan, std::size_t dropped_scans);

  /// The whole map, if the last one sent is out of date: for when sensors fall silent.
  void publishMapIfChanged(core::CekfSlam& filter);

  /// The map of a filter that began anew.
  void reset(core::CekfSlam& filter);

 private:
  FilterHealth healthMessage(core::CekfSlam& filter, const core::ScanOutcome& outcome,
                             std::size_t dropped_scans);
  bool publishMapIfDue(core::CekfSlam& filter, double time_s, bool large_correction);
  bool publishMap(core::CekfSlam& filter);
  template <class Message>
  void send(const ros::Publisher& publisher, Message message, const ros::Time& stamp) const;

  std::string map_frame_;
  double block_range_m_;
  std::uint64_t map_version_ = 0;  ///< of the last map asked for
  std::shared_ptr<std::atomic<int>> maps_on_their_way_ = std::make_shared<std::atomic<int>>(0);
  core::MapSchedule schedule_;
  bool map_was_sent_ = false;
  bool map_is_overdue_ = false;  ///< too many were on their way when it was due
  std::size_t map_corrections_ = 0;
  ros::Publisher observations_, landmarks_, updates_, pose_, health_;
  ros::Publisher landmark_markers_, observation_markers_;
};

}  // namespace hymm
