#pragma once

#include <cmath>
#include <limits>

#include <ros/time.h>

namespace hymm {

/// Seconds as a stamp; 0, which means none, for what a stamp cannot hold: a time that is negative
/// or not finite, as of a filter that has not begun.
inline ros::Time toRosTime(double time_s) {
  constexpr double kLast_s = std::numeric_limits<std::uint32_t>::max();
  return time_s >= 0.0 && time_s < kLast_s ? ros::Time(time_s) : ros::Time();
}

}  // namespace hymm
