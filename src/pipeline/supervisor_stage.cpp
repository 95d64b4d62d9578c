#include "pipeline/supervisor_stage.h"

#include <optional>
#include <variant>

#include "pipeline/grid_stage.h"
#include "pipeline/relocaliser_stage.h"

namespace hymm::core {
namespace {

RelocaliserEvidence evidenceFrom(const SearchReport& report) {
  using State = RelocaliserEvidence::State;
  RelocaliserEvidence evidence;
  evidence.reason = report.reason;
  switch (report.state) {
    case SearchState::kIdle:
    case SearchState::kSearching:
      evidence.state = State::kSearching;
      break;
    case SearchState::kAccepted:
      evidence.state = State::kAccepted;
      break;
    case SearchState::kRefused:
      evidence.state = State::kRefused;
      break;
    case SearchState::kFailed:
      evidence.state = State::kFailed;
      break;
  }
  return evidence;
}

}  // namespace

void SupervisorStage::watch(const GridStage* grid, RelocaliserStage* relocaliser) {
  grid_ = grid;
  relocaliser_ = relocaliser;
}

void SupervisorStage::takeScan(const ScanStep& step, CekfSlam& filter) {
  follow(step);
  pose_ = step.outcome.pose;
  if (decision_.mode == FilterMode::kRelocalising && relocaliser_ != nullptr) {
    if (const auto& found = relocaliser_->report().pose) {
      pose_.T_map_base = found->mean;
      pose_.covariance = found->covariance;
    }
  }
  const FilterMode before = decision_.mode;
  decision_ = computeDecision(decision_.state, evidenceOf(step), config_);
  has_switched_ = isModeSwitch(before, decision_.mode);
  act(filter);
}

void SupervisorStage::follow(const ScanStep& step) {
  if (step.map) landmarks_.take(*step.map);
  landmarks_.take(step.update);
  if (grid_ != nullptr && grid_->agreement()) {
    agreement_.take(step.outcome.pose.time_s, grid_->agreement()->correlation);
  }
}

SupervisorEvidence SupervisorStage::evidenceOf(const ScanStep& step) {
  const PoseEstimate& pose = step.outcome.pose;
  SupervisorEvidence evidence = evidenceAtScan(step.outcome.health);
  evidence.scan.disagreement = agreement_.disagreementAt(pose.time_s);
  evidence.of_detections = std::holds_alternative<ObservationSet>(step.event);
  evidence.waits = step.outcome.suspended;
  const OldLandmarksInView old = old_landmarks_.look(
      landmarks_.map().landmarks, pose.T_map_base * pose.T_base_sensor, pose.time_s);
  evidence.scan.old_landmarks_expected = old.expected;
  evidence.scan.unseen = old.unseenShare();
  if (relocaliser_ != nullptr) evidence.relocaliser = evidenceFrom(relocaliser_->report());
  return evidence;
}

void SupervisorStage::act(CekfSlam& filter) {
  if (decision_.action == SupervisorAction::kBeginRelocalising) {
    relocaliser_->begin({++orders_, decision_.from_s, pose_.time_s}, filter);
    return;
  }
  std::optional<double> from_s;
  if (decision_.action == SupervisorAction::kResumeWithoutClosing) from_s = decision_.from_s;
  const auto kept = filter.localStates();  // while the filter waits, up to where it does
  if (decision_.action == SupervisorAction::kEndWaiting && kept) from_s = kept->newest_s;
  if (from_s && !filter.resumeWithoutClosing(*from_s).accepted()) ++refused_returns_;
  if (relocaliser_ != nullptr && has_switched_) relocaliser_->end();
}

void SupervisorStage::reset(double) {
  landmarks_ = LandmarkMirror();
  agreement_.clear();
  old_landmarks_.clear();
  decision_ = {};
}

void SupervisorStage::addTo(RunTotals&) const {}

std::map<std::string, std::size_t> SupervisorStage::incidents() const {
  if (refused_returns_ == 0) return {};
  return {
      {"times that the filter could not go back to the last scan in good order", refused_returns_}};
}

}  // namespace hymm::core
