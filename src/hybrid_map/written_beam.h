#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "hybrid_map/occupancy_config.h"
#include "perception/laser_scan.h"

namespace hymm::core {

/// What a beam says of cells.
struct WrittenBeam {
  double length_m = 0.0;  ///< from the sensor: what it passes is free
  bool is_hit = false;    ///< where it ends something stands
};

/// Nothing if the beam says nothing.
inline std::optional<WrittenBeam> writtenBeam(const LaserScan& scan, std::size_t beam,
                                              const OccupancyConfig& config) {
  const auto range = static_cast<double>(scan.ranges_m[beam]);
  if (scan.isHit(range))
    return WrittenBeam{std::min(range, config.range_m), range <= config.range_m};
  // No return is told by infinity or the maximum; what lies beyond may as well be a mask.
  const bool has_no_return = range > 0.0 && (std::isinf(range) || range == scan.range_max_m);
  if (!has_no_return || config.clear_range_m <= 0.0) return std::nullopt;
  return WrittenBeam{std::min({config.clear_range_m, config.range_m, scan.range_max_m}), false};
}

}  // namespace hymm::core
