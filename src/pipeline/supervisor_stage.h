#pragma once

#include "pipeline/landmark_mirror.h"
#include "pipeline/suite_stage.h"
#include "supervisor/grid_agreement.h"
#include "supervisor/supervisor_decision.h"

namespace hymm::core {

class GridStage;
class RelocaliserStage;

/// The decisions of the node `supervisor` in an offline run.
class SupervisorStage : public SuiteStage {
 public:
  static constexpr const char* kName = "supervisor";

  explicit SupervisorStage(const SupervisorConfig& config)
      : config_(config), old_landmarks_(config.old_landmarks) {}

  /// Either may be missing; they outlive the stage.
  void watch(const GridStage* grid, RelocaliserStage* relocaliser);

  void takeScan(const ScanStep& step, CekfSlam& filter) override;
  void reset(double time_s) override;
  void addTo(RunTotals& totals) const override;
  std::map<std::string, std::size_t> incidents() const override;
  void write(const std::filesystem::path&) override {}

  /// What was decided on the last scan.
  const SupervisorDecision& decision() const { return decision_; }
  /// Whether that switched the mode.
  bool hasSwitched() const { return has_switched_; }
  /// The last scan's pose by the filter that was in charge of it.
  const PoseEstimate& pose() const { return pose_; }

 private:
  SupervisorEvidence evidenceOf(const ScanStep& step);
  void follow(const ScanStep& step);
  void act(CekfSlam& filter);

  SupervisorConfig config_;
  const GridStage* grid_ = nullptr;
  RelocaliserStage* relocaliser_ = nullptr;
  LandmarkMirror landmarks_;
  GridAgreement agreement_;
  OldLandmarkWatch old_landmarks_;
  SupervisorDecision decision_;
  bool has_switched_ = false;
  PoseEstimate pose_;
  std::uint64_t orders_ = 0;
  std::size_t refused_returns_ = 0;
};

}  // namespace hymm::core
