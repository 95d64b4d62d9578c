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
  explicit GridStage(const HymmGridConfig& config) : mapper_(config), image_(config.image) {}

  void takeScan(const ScanStep& step, CekfSlam& filter) override;
  void reset(double time_s) override;
  void addTo(RunTotals& totals) const override;
  std::map<std::string, std::size_t> incidents() const override;
  void write(const std::filesystem::path& folder) override;

  const GridMapper& mapper() const { return mapper_; }
  /// How well the last scan agrees with the map, where that was computed.
  const std::optional<ScanAgreement>& agreement() const { return agreement_; }

 private:
  GridMapper mapper_;
  std::optional<ScanAgreement> agreement_;
  MapImage image_;  ///< drawn at the end
  MapMemoryLog memory_log_;
  StampSchedule memory_due_{kMemoryLogPeriod_s};
};

}  // namespace hymm::core
