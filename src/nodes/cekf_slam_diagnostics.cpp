#include <algorithm>

#include "nodes/cekf_slam_node.h"

/// What the node `cekf_slam` tells in /diagnostics.
namespace hymm {
namespace {

using Status = diagnostic_updater::DiagnosticStatusWrapper;
using diagnostic_msgs::DiagnosticStatus;

constexpr std::size_t kManyScans = 100;  // a drive may begin where there is no landmark yet

void addObservations(const core::CekfSlam::Counts& counts, Status& status) {
  status.add("scans used", counts.scans);
  status.add("scans refused", counts.refused_scans);
  status.add("motion refused", counts.refused_motion);
  status.add("observations refused", counts.refused_observations);
  status.add("motion gaps", counts.motion_gaps);
  status.add("scans without motion", counts.scans_without_motion);
  status.add("observations", counts.observations);
  status.add("observations associated", counts.associated);
  status.add("observations rejected", counts.rejected);
  status.add("associations cut short", counts.bounded_associations);
  status.add("slips (motion much worse than it claims)", counts.slips);
  status.add("places found among all landmarks", counts.places_found);
  status.add("scans without a place", counts.scans_without_place);
  if (counts.bounded_associations > 0) {
    status.mergeSummary(DiagnosticStatus::WARN,
                        "Scans with more landmarks than association.max_nodes lets be searched");
  }
}

void addGlobalUpdates(const core::CekfSlam::Counts& counts, double worker_s, Status& status) {
  status.add("area switches", counts.area_switches);
  status.add("global updates", counts.global_updates);
  status.add("global updates deferred", counts.deferred_global_updates);
  status.add("scans that waited for a global update", counts.global_update_waits);
  const double worker_ms = 1e3 * worker_s;
  status.add("worker CPU a scan [ms]",
             counts.scans > 0 ? worker_ms / static_cast<double>(counts.scans) : 0.0);
  if (counts.global_update_waits > 0) {
    status.mergeSummary(DiagnosticStatus::WARN,
                        "Scans waited for global updates: the machine is too slow for this map");
  }
}

}  // namespace

void CekfSlamNode::diagnoseInputs(diagnostic_updater::DiagnosticStatusWrapper& status) {
  status.summary(DiagnosticStatus::OK, "All inputs arrive");
  inputs_.traffic().addTo(status);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (paused_) status.mergeSummary(DiagnosticStatus::WARN, "Paused");
  if (!backlog_.empty()) {
    status.mergeSummary(DiagnosticStatus::WARN, "Waiting for tf to place the sensor");
  }
  const SensorQueue::Counts queue = queue_.counts();
  status.add("queued messages", queue_.size() + backlog_.size());
  status.add("dropped messages (queue full)", queue.dropped);
  status.add("dropped messages (out of order)", merger_.counts().out_of_order);
  status.add("dropped scans", droppedScans());
  status.add("scans without motion past their stamp", merger_.counts().without_motion);
  status.add("clock resets", merger_.counts().clock_resets);
  for (const auto& [cause, count] : causes_.counts()) status.add(cause, count);
  if (droppedScans() > 0) status.mergeSummary(DiagnosticStatus::WARN, "Scans were dropped");
}

void CekfSlamNode::diagnoseFilter(diagnostic_updater::DiagnosticStatusWrapper& status) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const core::CekfSlam::Counts counts = filter_.counts();
  status.summary(DiagnosticStatus::OK, std::to_string(filter_.landmarkCount()) + " landmarks");
  if (counts.scans == 0) status.mergeSummary(DiagnosticStatus::WARN, "No scan has been used");
  if (counts.scans >= kManyScans && filter_.landmarkCount() == 0) {
    status.mergeSummary(DiagnosticStatus::WARN, "No landmark in " + std::to_string(counts.scans) +
                                                    " scans: the pose is dead reckoning");
  }
  status.add("landmarks", filter_.landmarkCount());
  addObservations(counts, status);
  addGlobalUpdates(counts, filter_.cpuTimes().worker_s, status);
  status.add("global update pending", filter_.isGlobalUpdatePending() ? 1 : 0);
  status.add("GPS fixes used", counts.gps_used);
  status.add("GPS fixes rejected", counts.gps_rejected);
  status.add("landmarks created", counts.landmarks_created);
  status.add("landmarks dropped", counts.landmarks_dropped);
  status.add("landmarks merged", counts.landmarks_merged);
  status.add("map corrections", counts.map_corrections);
  status.add("iterated updates", counts.iterated_updates);
  status.add("updates refused, which diverged", counts.diverged_updates);
  status.add("resets", counts.resets);
  status.add("returns to an earlier scan", counts.resumed);
  status.add("returns refused", counts.refused_resumptions);
  status.add("scans given up that could be gone back to", counts.forgotten_states);
  if (filter_.isSuspended()) {
    status.mergeSummary(DiagnosticStatus::WARN, "Waits while the relocaliser looks for the place");
  }
  const Eigen::Vector2d noise = filter_.motionNoiseFactors().cwiseSqrt();
  status.add("deviation of the speed, in those that the vehicle's noise claims", noise[0]);
  status.add("deviation of the turn, in those that the vehicle's noise claims", noise[1]);
  if (noise.maxCoeff() >= 2.0) {
    status.mergeSummary(DiagnosticStatus::WARN,
                        "The motion is at least twice as noisy as the vehicle's noise claims");
  }
  status.add("latency, worst of the last second [ms]", worst_latency_ms_);
  status.add("NIS per degree of freedom", health_.dof > 0 ? health_.nis / health_.dof : 0.0);
  status.add("position deviation [m]", health_.position_deviation_m);
  status.add("heading deviation [rad]", health_.heading_deviation_rad);
  worst_latency_ms_ = 0.0;
}

}  // namespace hymm
