#pragma once

#include <vector>

#include "cekf/landmark_map.h"
#include "common/config.h"
#include "common/pose2.h"

namespace hymm::core {

/// Which landmarks count as old, and as being in view.
struct OldLandmarkConfig {
  double age_s = 60.0;          ///< since the scan that put it into the map
  double range_m = 15.0;        ///< from the sensor
  double half_angle_rad = 1.3;  ///< from the sensor's x axis
  int least_observations = 10;
  double unseen_s = 2.0;  ///< after its last sighting one has not been seen lately

  void describe(ConfigSchema& schema);
};

/// Old landmarks that should be in view.
struct OldLandmarksInView {
  int expected = 0;
  int unseen = 0;  ///< of these, not seen lately

  double unseenShare() const { return expected > 0 ? static_cast<double>(unseen) / expected : 0.0; }
};

/// Those landmarks that were in the map for long and that the sensor should see from where the
/// filter takes it to be. What hides them is not known here.
OldLandmarksInView countOldLandmarksInView(const std::vector<LandmarkEstimate>& landmarks,
                                           const Pose2& T_map_sensor, double time_s,
                                           const OldLandmarkConfig& config);

}  // namespace hymm::core
