#pragma once

#include "common/stamp_schedule.h"
#include "pipeline/grid_files.h"
#include "pipeline/grid_mapper.h"
#include "pipeline/suite_stage.h"

namespace hymm::core {

/// The engine of the node `hymm_grid` in an offline run.
class GridStage : public SuiteStage {
 public:
  static constexpr const char* kName = "hymm_grid";

  /// Throws ConfigError if the configuration is unusable.
  explicit GridStage(const HymmGridConfig& config)
      : settings_(settingsOf(config)), mapper_(config), image_(config.image) {}

  void takeSample(const RecordedSample& sample) override { samples_.add(sample); }
  void takeScan(const ScanStep& step, CekfSlam& filter) override;
  void reset(double time_s) override;
  std::optional<NamedPart> savedPart() const override {
    return NamedPart{partName(), {settings_, mapper_.saveState()}};
  }
  std::string partName() const override { return MapPart::kDenseMap; }
  void load(const NamedPart& part, std::uint64_t landmark_version, MapUse use) override {
    mapper_.loadState(part.part.state, part.name, landmark_version, use);
  }
  SavedSettings settings() const override { return settings_; }
  void addTo(RunTotals& totals) const override;
  std::map<std::string, std::size_t> incidents() const override;
  void write(const std::filesystem::path& folder) override;

  const GridMapper& mapper() const { return mapper_; }
  /// How well the last scan agrees with the map, where that was computed.
  const std::optional<ScanAgreement>& agreement() const { return agreement_; }

 private:
  void writeSamples(const ScanOutcome& outcome);

  SavedSettings settings_;
  GridMapper mapper_;
  std::optional<ScanAgreement> agreement_;
  RecordedSamples samples_;
  struct Refusal {
    std::string first_reason;
    std::size_t count = 0;
  };
  std::map<std::string, Refusal> refused_samples_;  ///< by layer
  MapImage image_;                                  ///< drawn at the end
  MapMemoryLog memory_log_;
  StampSchedule memory_due_{kMemoryLogPeriod_s};
};

}  // namespace hymm::core
