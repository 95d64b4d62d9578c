#pragma once

#include <string>

#include "common/config.h"
#include "hybrid_map/hybrid_map_config.h"
#include "hybrid_map/map_image.h"
#include "hybrid_map/scan_matcher.h"

namespace hymm::core {

/// Parameters of the node `hymm_grid`, as config/hymm_grid.yaml documents them.
struct HymmGridConfig {
  HybridMapConfig map;  ///< its names stand at the top level
  std::string scan_input = "scan";
  double min_range_m = 1.0;
  MapImageConfig image;
  ScanMatcherConfig scan_matching;
  double publish_rate_hz = 1.0;
  double whole_map_period_s = 10.0;
  double sample_wait_s = 2.0;

  void describe(ConfigSchema& schema);
};

}  // namespace hymm::core
