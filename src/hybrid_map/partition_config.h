#pragma once

#include "common/config.h"

namespace hymm::core {

/// Which landmarks span LTRs, and how far an LTR may change before it is given up.
struct PartitionConfig {
  int min_observations = 5;
  double min_side_m = 2.0;
  double max_side_m = 30.0;
  double min_angle_rad = 0.3;
  double min_gap_height_m = 1.0;
  double clearance_m = 0.3;
  double max_shape_factor = 1.3;
  double max_stretch = 1.5;

  void describe(ConfigSchema& schema);
};

}  // namespace hymm::core
