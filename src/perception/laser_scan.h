#pragma once

#include <vector>

namespace hymm::core {

/// One turn of a planar laser. Angles counter-clockwise from the sensor's x axis. Ranges follow
/// REP-117: +inf is no return, -inf too close to measure, NaN an invalid measurement.
struct LaserScan {
  double time_s = 0.0;               ///< of the scan, as stamped
  double angle_min_rad = 0.0;        ///< bearing of ranges_m[0]
  double angle_increment_rad = 0.0;  ///< between neighbours in ranges_m
  double range_min_m = 0.0;
  double range_max_m = 0.0;
  std::vector<float> ranges_m;
  std::vector<float> intensities;  ///< as long as ranges_m, or empty; unit of the device

  double bearing(std::size_t index) const {
    return angle_min_rad + static_cast<double>(index) * angle_increment_rad;
  }

  /// Whether a range is where a beam ended. The maximum itself is how some drivers say "no return".
  bool isHit(double range_m) const { return range_m >= range_min_m && range_m < range_max_m; }
};

}  // namespace hymm::core
