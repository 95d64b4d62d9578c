#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "common/pose2.h"

namespace hymm::core {

/// The stamp of the last scan, and which sensors have brought one of it: several lasers may share a
/// stamp, and each brings one scan of it. A sensor is known by its place on the vehicle.
class ScanClock {
 public:
  static constexpr std::size_t kMostSensors = 16;  ///< of one stamp

  explicit ScanClock(double last_s = -std::numeric_limits<double>::infinity()) : last_s_(last_s) {}

  double last_s() const { return last_s_; }

  /// Whether a scan is later than the last one, or of the same stamp and another sensor.
  bool takes(double time_s, const Pose2& T_base_sensor) const {
    if (time_s != last_s_) return time_s > last_s_;
    return !sensors_.empty() && sensors_.size() < kMostSensors &&
           std::none_of(sensors_.begin(), sensors_.end(), [&](const Pose2& sensor) {
             return sensor.vector() == T_base_sensor.vector();
           });
  }

  void note(double time_s, const Pose2& T_base_sensor) {
    if (time_s != last_s_) sensors_.clear();
    last_s_ = time_s;
    sensors_.push_back(T_base_sensor);
  }

 private:
  double last_s_;
  std::vector<Pose2> sensors_;  ///< empty: not known, as of a map that was loaded
};

}  // namespace hymm::core
