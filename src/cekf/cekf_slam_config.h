#pragma once

#include <string>

#include "common/config.h"
#include "perception/perception_config.h"
#include "pipeline/sensor_merger.h"

namespace hymm::core {

/// Parameters of the node `cekf_slam`, as config/cekf_slam.yaml documents them. The groups
/// `active_area`, `association`, `landmarks` and `gps` belong to the filter's own folder.
struct CekfSlamConfig {
  std::string motion_input = "dead_reckoning";  ///< or "odom"
  std::string observation_input = "scan";       ///< or "detections"
  double landmark_block_range_m = 30.0;         ///< of the cross-covariances in `landmarks`
  double landmark_rate_hz = 1.0;                ///< highest rate of `landmarks`
  SensorMergerConfig merger;
  PerceptionConfig perception;

  void describe(ConfigSchema& schema);
};

}  // namespace hymm::core
