#pragma once

#include <optional>
#include <string>

#include "common/cpu_timer.h"
#include "hybrid_map/map_image.h"
#include "information_map/information_map.h"
#include "pipeline/grid_mapper.h"
#include "pipeline/suite_stage.h"

namespace hymm::core {

/// The engine of the node `information_map` in an offline run.
class InformationStage : public SuiteStage {
 public:
  static constexpr const char* kName = "information_map";

  /// Throws ConfigError if the configuration is unusable.
  InformationStage(const InformationMapConfig& config, const VehicleConfig& vehicle,
                   const MapImageConfig& image = {});

  /// The dense map that bars ways and hides landmarks, which outlives the object.
  void readMapOf(const GridMapper& mapper) { mapper_ = &mapper; }

  void takeScan(const ScanStep& step, CekfSlam& filter) override;
  void reset(double time_s) override;
  void addTo(RunTotals& totals) const override;
  std::map<std::string, std::size_t> incidents() const override;
  void write(const std::filesystem::path& folder) override;

  const InformationMap& information() const { return information_; }

 private:
  void takeDenseMap();

  InformationMap information_;
  bool needs_dense_map_;  ///< with each change of the landmarks, not only at the end
  const GridMapper* mapper_ = nullptr;
  MapImageConfig image_config_;
  MapImage image_;
  std::optional<PoseEstimate> pose_;  ///< of the last scan
  double cpu_s_ = 0.0;
  std::string changes_;  ///< content of information_changes.csv
};

/// The content of level_sets.csv: the leaves of all sets.
std::string levelSetsText(const LevelSets& sets);

/// The content of exploration.csv: suggested goals, best first.
std::string explorationText(const ExplorationAnswer& answer);

}  // namespace hymm::core
