#include "pipeline/offline_run.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/suite_stages.h"

namespace hymm::core {
namespace {

bool isScan(const SensorEvent& event) {
  return std::holds_alternative<ScanEvent>(event) || std::holds_alternative<ObservationSet>(event);
}

}  // namespace

OfflineRun::OfflineRun(const SuiteConfig& config, const std::vector<std::string>& nodes,
                       ResultsWriter& results)
    : config_(config),
      results_(results),
      merger_(config.cekf_slam.merger),
      filter_(config.cekf_slam, config.vehicle),
      sights_(config.cekf_slam.perception),
      map_schedule_(config.cekf_slam),
      stages_(makeStages(nodes, config)),
      supervisor_(findSupervisor(stages_)) {
  // Nothing else would go back to one.
  const bool can_go_back = std::find(nodes.begin(), nodes.end(), "relocaliser") != nodes.end();
  if (can_go_back) filter_.keepLocalStates(config.cekf_slam.local_states_s);
}

bool OfflineRun::process(SensorEvent event) {
  if (isScan(event)) ++scans_in_;
  if (!std::isfinite(timeOf(event))) {
    ++incidents_["messages with a stamp that is not finite"];
    return false;
  }
  const std::size_t resets = merger_.counts().clock_resets;
  merger_.push(std::move(event));
  for (const SensorEvent& released : merger_.popReady()) processReleased(released);
  return merger_.counts().clock_resets > resets;
}

void OfflineRun::process(const RecordedSample& sample) {
  for (const auto& stage : stages_) stage->takeSample(sample);
}

void OfflineRun::finish() {
  for (const SensorEvent& released : merger_.flush()) processReleased(released);
}

void OfflineRun::processReleased(const SensorEvent& event) {
  if (const auto* reset = std::get_if<ClockReset>(&event)) {
    ++incidents_["times that the clock ran back and a new map was begun"];
    results_.addReset(reset->time_s, "the clock ran back; a new map begins");
    map_schedule_.reset();
    for (const auto& stage : stages_) stage->reset(reset->time_s);
  } else if (const auto* fix = std::get_if<GpsFix>(&event)) {
    results_.addGps(*fix);
  }
  if (const auto* scan = std::get_if<ScanEvent>(&event)) sights_.take(scan->scan);
  for (const auto& stage : stages_) stage->takeEvent(event);
  if (std::holds_alternative<MotionInput>(event)) ++motion_inputs_;
  const std::optional<ScanOutcome> outcome = filter_.process(event);
  if (!outcome) return;
  if (outcome->accepted) {
    finishScan(event, *outcome);
  } else {
    ++incidents_["scans refused: " + outcome->reason];
  }
}

void OfflineRun::finishScan(const SensorEvent& event, const ScanOutcome& outcome) {
  if (!stages_.empty()) serveStages(event, outcome);
  record(outcome);
  // After the first record, which removes what an earlier run left in the folder.
  if (log_ != nullptr) log_->add(outcome);
}

/// As FilterOutput publishes it: what changed with each scan, and now and then all landmarks.
void OfflineRun::serveStages(const SensorEvent& event, const ScanOutcome& outcome) {
  const LandmarkUpdate update = filter_.takeUpdate();
  std::shared_ptr<const LandmarkMap> map;
  const double time_s = outcome.pose.time_s;
  if (map_schedule_.isDue(time_s, filter_.counts().map_corrections > map_corrections_)) {
    map_schedule_.note(time_s);
    map = std::make_shared<const LandmarkMap>(
        filter_.landmarkMap(config_.cekf_slam.landmark_block_range_m));
  }
  map_corrections_ = filter_.counts().map_corrections;
  for (const auto& stage : stages_) stage->takeScan({event, outcome, update, map}, filter_);
}

void OfflineRun::writeFiles(const std::string& folder) {
  for (const auto& stage : stages_) stage->write(folder);
}

void OfflineRun::record(const ScanOutcome& outcome) {
  if (supervisor_ == nullptr) {
    results_.addScan({outcome.pose, outcome.health, nameOf(FilterMode::kCekf)});
    return;
  }
  const SupervisorDecision& decision = supervisor_->decision();
  const std::string mode = nameOf(decision.mode);
  if (supervisor_->hasSwitched()) {
    results_.addModeSwitch(outcome.pose.time_s, mode, decision.reason);
  }
  results_.addScan({supervisor_->pose(), outcome.health, mode});
}

std::map<std::string, std::size_t> OfflineRun::incidents() const {
  std::map<std::string, std::size_t> incidents = incidents_;
  const auto add = [&](const char* what, std::size_t count) {
    if (count > 0) incidents[what] += count;
  };
  const CekfSlam::Counts counts = filter_.counts();
  add("messages dropped: older than what was processed", merger_.counts().out_of_order);
  add("motion inputs refused: not finite, or not later than the last", counts.refused_motion);
  add("observations refused: not finite, or with an unusable covariance",
      counts.refused_observations);
  add("gaps in the motion input", counts.motion_gaps);
  add("scans after a motion at least twice as noisy as the vehicle's noise claims",
      counts.noisy_scans);
  add("scans before any motion input", counts.scans_without_motion);
  add("scans of which nothing was made: the heading was too uncertain to tell where",
      counts.scans_without_place);
  add("times that the place was found again among all landmarks", counts.places_found);
  for (const auto& stage : stages_) incidents.merge(stage->incidents());
  return incidents;
}

RunTotals OfflineRun::totals() const {
  const CekfSlam::Counts counts = filter_.counts();
  RunTotals totals;
  totals.subsystem_cpu_s = {{"perception", filter_.cpuTimes().perception_s},
                            {"filter", filter_.cpuTimes().filter_s},
                            {"worker", filter_.cpuTimes().worker_s}};
  totals.dropped_scans = scans_in_ - counts.scans;
  totals.observations = counts.observations;
  totals.associated = counts.associated;
  totals.rejected = counts.rejected;
  totals.map_corrections = counts.map_corrections;
  totals.global_updates = counts.global_updates;
  totals.deferred_global_updates = counts.deferred_global_updates;
  totals.global_update_waits = counts.global_update_waits;
  totals.gps_antenna_m =
      Eigen::Vector2d(config_.vehicle.gps_antenna.x_m, config_.vehicle.gps_antenna.y_m);
  for (const auto& stage : stages_) stage->addTo(totals);
  return totals;
}

}  // namespace hymm::core
