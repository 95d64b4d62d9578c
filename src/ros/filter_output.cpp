#include "ros/filter_output.h"

#include <utility>

#include "ros/filter_conversions.h"
#include "ros/map_conversions.h"
#include "ros/markers.h"
#include "ros/process_usage.h"
#include "ros/sensor_conversions.h"

namespace hymm {
namespace {

constexpr std::uint32_t kQueue = 5000;  // scans, a quarter of an hour; hymm_grid waits for no more
constexpr bool kLatched = true;
constexpr int kMostMapsOnTheirWay = 10;

}  // namespace

FilterOutput::FilterOutput(ros::NodeHandle handle, const core::CekfSlamConfig& config,
                           std::string map_frame)
    : map_frame_(std::move(map_frame)),
      block_range_m_(config.landmark_block_range_m),
      schedule_(config) {
  observations_ = handle.advertise<LandmarkObservations>("landmark_observations", kQueue);
  landmarks_ = handle.advertise<LandmarkMap>("landmarks", 10, kLatched);
  updates_ = handle.advertise<LandmarkUpdate>("landmark_updates", kQueue);
  pose_ = handle.advertise<FilterPose>("cekf/pose", kQueue);
  health_ = handle.advertise<FilterHealth>("cekf/health", kQueue);
  landmark_markers_ =
      handle.advertise<visualization_msgs::MarkerArray>("landmark_markers", 2, kLatched);
  observation_markers_ =
      handle.advertise<visualization_msgs::MarkerArray>("observation_markers", 2);
}

void FilterOutput::publish(core::CekfSlam& filter, const core::ScanOutcome& outcome,
                           const std_msgs::Header& scan, std::size_t dropped_scans) {
  send(observations_, toMessage(outcome.observations, scan.frame_id), scan.stamp);
  LandmarkUpdate update = toMessage(filter.takeUpdate(), outcome.pose.time_s, map_frame_);
  const FilterHealth health = healthMessage(filter, outcome, dropped_scans);
  update.map_follows = publishMapIfDue(filter, outcome.pose.time_s, health.map_correction);
  send(updates_, update, scan.stamp);
  FilterPose pose = toMessage(outcome.pose, map_frame_);
  pose.resets = health.resets;
  pose.suspended = outcome.suspended;
  send(pose_, pose, scan.stamp);
  send(health_, health, scan.stamp);
  if (observation_markers_.getNumSubscribers() > 0) {
    observation_markers_.publish(observationMarkers(outcome, map_frame_));
  }
}

template <class Message>
void FilterOutput::send(const ros::Publisher& publisher, Message message,
                        const ros::Time& stamp) const {
  message.header.stamp = stamp;
  publisher.publish(message);
}

void FilterOutput::publishMapIfChanged(core::CekfSlam& filter) {
  if (!map_was_sent_ || filter.mapVersion() != map_version_) publishMap(filter);
}

void FilterOutput::reset(core::CekfSlam& filter) {
  schedule_.reset();
  publishMap(filter);
}

FilterHealth FilterOutput::healthMessage(core::CekfSlam& filter, const core::ScanOutcome& outcome,
                                         std::size_t dropped_scans) {
  FilterHealth message = toMessage(outcome.health, map_frame_);
  const auto counts = filter.counts();
  message.largest_correction = outcome.largest_correction_m;
  message.map_correction = counts.map_corrections > map_corrections_;
  map_corrections_ = counts.map_corrections;
  message.scans = counts.scans;
  message.refused_scans = counts.refused_scans;
  message.dropped_scans = dropped_scans;
  message.observations = counts.observations;
  message.associated = counts.associated;
  message.rejected = counts.rejected;
  message.map_corrections = counts.map_corrections;
  message.resets = counts.resets;
  message.landmarks = static_cast<std::uint32_t>(filter.landmarkCount());
  message.global_updates = counts.global_updates;
  message.deferred_global_updates = counts.deferred_global_updates;
  message.global_update_waits = counts.global_update_waits;
  message.global_update_pending = filter.isGlobalUpdatePending();
  const core::CekfSlam::CpuTimes cpu = filter.cpuTimes();
  message.perception_cpu_s = cpu.perception_s;
  message.filter_cpu_s = cpu.filter_s;
  message.worker_cpu_s = cpu.worker_s;
  const ProcessUsage usage = processUsage();
  message.process_cpu_s = usage.cpu_s;
  message.peak_rss_mb = usage.peak_rss_mb;
  return message;
}

bool FilterOutput::publishMapIfDue(core::CekfSlam& filter, double time_s, bool large_correction) {
  if (!map_is_overdue_ && !schedule_.isDue(time_s, large_correction)) return false;
  schedule_.note(time_s);
  return publishMap(filter);
}

/// False, and the map is overdue, while too many are on their way. That some are must not change
/// which maps there are: these decide how the dense map grows.
bool FilterOutput::publishMap(core::CekfSlam& filter) {
  map_is_overdue_ = *maps_on_their_way_ >= kMostMapsOnTheirWay;
  if (map_is_overdue_) return false;
  ++*maps_on_their_way_;
  map_version_ = filter.mapVersion();
  map_was_sent_ = true;
  filter.requestMap(block_range_m_, [on_their_way = maps_on_their_way_, landmarks = landmarks_,
                                     markers = landmark_markers_, range_m = block_range_m_,
                                     frame = map_frame_](const core::LandmarkMap& map) {
    landmarks.publish(toMessage(map, range_m, frame));
    markers.publish(landmarkMarkers(map, frame));
    --*on_their_way;
  });
  return true;
}

}  // namespace hymm
