#pragma once

#include "pipeline/sensor_event.h"

namespace hymm::core {

inline SensorEvent motion(double time_s) { return MotionInput{TwistInput{time_s, 1.0, 0.0, 0.0}}; }

inline SensorEvent detections(double time_s) {
  ObservationSet set;
  set.time_s = time_s;
  return set;
}

}  // namespace hymm::core
