#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cekf/landmark_map.h"
#include "common/config.h"
#include "relocaliser/local_map.h"

namespace hymm::core {

/// Which landmarks make the map for a vehicle that may be anywhere.
struct WholeMapConfig {
  int least_observations = 5;
  double max_deviation_m = 3.0;  ///< of a landmark, map frame

  void describe(ConfigSchema& schema);
};

/// All landmarks that are known well, in the map frame, as if independent of each other. They are
/// not, and (37) for so many would leave nothing of what they tell: a place found in it is a guess,
/// around which a LocalMap has to confirm it. Nothing, and the reason in `problem`, if fewer than
/// two are left.
std::optional<LocalMap> tryMakeWholeMap(const std::vector<LandmarkEstimate>& landmarks,
                                        const WholeMapConfig& config, std::string& problem);

}  // namespace hymm::core
