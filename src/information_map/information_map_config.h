#pragma once

#include <string>
#include <vector>

#include "information_map/information_config.h"
#include "information_map/sight_map.h"

namespace hymm::core {

/// Which level sets are kept, how fine, and what may be spent on them.
struct LevelSetConfig {
  std::string values = "25 100";
  double resolution_m = 1.0;
  double max_cells = 2e7;
  int max_evaluations = 20000;
  std::string losses = "drop";

  void describe(ConfigSchema& schema);

  /// The values in ascending order [1/m^2]; `problems` gets a sentence for each that is none.
  std::vector<double> valuesAscending(std::vector<std::string>& problems) const;
};

/// What an exploring vehicle may risk.
struct ExplorationConfig {
  double max_position_deviation_m = 0.5;
  double max_heading_deviation_rad = 0.05;
  double speed_mps = 3.0;
  double spacing_m = 5.0;
  int max_suggestions = 20;

  void describe(ConfigSchema& schema);
};

/// Parameters of the information map, as config/information_map.yaml documents them.
struct InformationMapConfig {
  InformationConfig information;
  LevelSetConfig level_sets;
  DenseMapConfig dense_map;
  ExplorationConfig exploration;

  void describe(ConfigSchema& schema);

  /// Everything that makes the configuration unusable, one sentence each.
  std::vector<std::string> problems() const;
};

}  // namespace hymm::core
