#pragma once

#include "common/config.h"

namespace hymm::core {

/// How beams become occupancy (1). Of an occupied cell a beam meets what is in it in about 0.4 of
/// all cases and else passes by, of a free one in less than 0.001 (counted in four simulated
/// worlds, doc/hybrid_map.md). So a hit says almost as much as a map may know of a cell
/// at all: where it was surely free, one hit leaves it in doubt, and the next one decides.
struct OccupancyConfig {
  double hit_probability = 0.95;
  double miss_probability = 0.4;
  double min_probability = 0.03;
  double max_probability = 0.97;
  double range_m = 30.0;
  /// A laser that sees a target of 10 % reflectivity at 30 m, as data sheets tell it, loses it at
  /// half of that only where it looks along it within 15 degrees: the echo falls with the cosine of
  /// the incidence over the square of the range.
  double clear_range_m = 15.0;

  void describe(ConfigSchema& schema);
};

}  // namespace hymm::core
