#pragma once

#include <string>

#include "common/cpu_timer.h"
#include "information_map/information_map.h"
#include "pipeline/suite_stage.h"

namespace hymm::core {

/// The engine of the node `information_map` in an offline run.
class InformationStage : public SuiteStage {
 public:
  static constexpr const char* kName = "information_map";

  /// Throws ConfigError if the configuration is unusable.
  InformationStage(const InformationMapConfig& config, const VehicleConfig& vehicle);

  void takeScan(const ScanStep& step, CekfSlam& filter) override;
  void reset(double time_s) override;
  void addTo(RunTotals& totals) const override;
  std::map<std::string, std::size_t> incidents() const override;
  void write(const std::filesystem::path& folder) override;

  const InformationMap& information() const { return information_; }

 private:
  InformationMap information_;
  double cpu_s_ = 0.0;
  std::string changes_;  ///< content of information_changes.csv
};

/// The content of level_sets.csv: the leaves of all sets.
std::string levelSetsText(const LevelSets& sets);

}  // namespace hymm::core
