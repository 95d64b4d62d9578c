#pragma once

#include <cstddef>
#include <limits>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/sensor_event.h"

namespace hymm::core {

inline SensorEvent motion(double time_s) { return MotionInput{TwistInput{time_s, 1.0, 0.0, 0.0}}; }

inline SensorEvent detections(double time_s) {
  ObservationSet set;
  set.time_s = time_s;
  return set;
}

inline SensorEvent fixAt(double time_s) {
  GpsFix fix;
  fix.time_s = time_s;
  return fix;
}

/// Counts events by their kinds, and expects them in order between clock resets.
class EventTally {
 public:
  std::size_t motions = 0, scans = 0, fixes = 0, resets = 0;

  void take(const std::vector<SensorEvent>& events) {
    for (const SensorEvent& event : events) take(event);
  }

 private:
  static constexpr double kNever = -std::numeric_limits<double>::infinity();

  void take(const SensorEvent& event) {
    if (std::holds_alternative<ClockReset>(event)) {
      ++resets;
      last_s_ = kNever;
      return;
    }
    EXPECT_GE(timeOf(event), last_s_);
    last_s_ = timeOf(event);
    if (std::holds_alternative<MotionInput>(event)) ++motions;
    if (std::holds_alternative<ObservationSet>(event)) ++scans;
    if (std::holds_alternative<GpsFix>(event)) ++fixes;
  }

  double last_s_ = kNever;
};

}  // namespace hymm::core
