#pragma once

#include "common/config.h"
#include "hybrid_map/hybrid_map_config.h"

namespace hymm::core {

/// Parameters of the node `hymm_grid`, as config/hymm_grid.yaml documents them.
struct HymmGridConfig {
  HybridMapConfig map;  ///< its names stand at the top level

  void describe(ConfigSchema& schema) { map.describe(schema); }
};

}  // namespace hymm::core
