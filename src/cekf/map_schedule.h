#pragma once

#include <optional>

#include "cekf/cekf_slam_config.h"

namespace hymm::core {

/// When the whole landmark map is due: at the first scan, at most landmark_rate_hz, and at once
/// after a large correction. By stamps only, so that live and offline agree.
class MapSchedule {
 public:
  explicit MapSchedule(const CekfSlamConfig& config) : period_s_(1.0 / config.landmark_rate_hz) {}

  bool isDue(double time_s, bool large_correction) const {
    return large_correction || !last_s_ || time_s >= *last_s_ + period_s_ || time_s < *last_s_;
  }
  void note(double time_s) { last_s_ = time_s; }

  /// A new map begins.
  void reset() { last_s_.reset(); }

 private:
  double period_s_;
  std::optional<double> last_s_;
};

}  // namespace hymm::core
