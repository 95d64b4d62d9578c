#pragma once

#include <algorithm>
#include <vector>

#include "common/pose2.h"

namespace hymm::core {

/// One turn of a planar laser. Angles counter-clockwise from the sensor's x axis. Ranges follow
/// REP-117: +inf is no return, -inf too close to measure, NaN an invalid measurement.
struct LaserScan {
  double time_s = 0.0;               ///< of the first beam, as stamped
  double time_increment_s = 0.0;     ///< from a beam to the next, as told; see sweep_s()
  double angle_min_rad = 0.0;        ///< bearing of ranges_m[0]
  double angle_increment_rad = 0.0;  ///< between neighbours in ranges_m
  double range_min_m = 0.0;
  double range_max_m = 0.0;
  std::vector<float> ranges_m;
  std::vector<float> intensities;  ///< as long as ranges_m, or empty; unit of the device
  /// When each beam was measured, after time_s; as long as ranges_m, or empty: time_increment_s
  /// tells it.
  std::vector<float> beam_times_s;
  /// Where the sensor was at each beam, from where it was at the stamp; as long as ranges_m, or
  /// empty: it did not move, or nobody has told.
  std::vector<Pose2> T_stamp_beam;

  static constexpr double kInstant_s = 1e-4;      ///< a sweep that counts as one: 3 mm at 30 m/s
  static constexpr double kLongestSweep_s = 1.0;  ///< longer ones are told in another unit

  double bearing(std::size_t index) const {
    return angle_min_rad + static_cast<double>(index) * angle_increment_rad;
  }

  /// Whether a range is where a beam ended. The maximum itself is how some drivers say "no return".
  bool isHit(double range_m) const { return range_m >= range_min_m && range_m < range_max_m; }

  /// From the stamp to the last beam measured; 0 where all count as measured at the stamp, be it
  /// that the time increment makes no sense.
  double sweep_s() const {
    if (ranges_m.empty()) return 0.0;
    double sweep_s = time_increment_s * static_cast<double>(ranges_m.size() - 1);
    if (!beam_times_s.empty()) {
      sweep_s = static_cast<double>(*std::max_element(beam_times_s.begin(), beam_times_s.end()));
    }
    return sweep_s > kInstant_s && sweep_s <= kLongestSweep_s ? sweep_s : 0.0;
  }

  /// When a beam was measured, after the stamp, if sweep_s() is not 0.
  double beamTime_s(std::size_t index) const {
    return beam_times_s.empty() ? static_cast<double>(index) * time_increment_s
                                : static_cast<double>(beam_times_s[index]);
  }

  /// Where the sensor was at a beam, if it was at `T_parent_sensor` at the stamp.
  Pose2 poseAtBeam(std::size_t index, const Pose2& T_parent_sensor) const {
    return T_stamp_beam.empty() ? T_parent_sensor : T_parent_sensor * T_stamp_beam[index];
  }
};

}  // namespace hymm::core
