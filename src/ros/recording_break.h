#pragma once

#include <cmath>

#include <ros/time.h>

namespace hymm {

/// Where one map ends and the next begins: the stamps of the last scan before and of the first one
/// after. What else was recorded comes on other topics, so that some of either side may come on
/// the other.
struct RecordingBreak {
  ros::Time last, first;

  bool clockRanBack() const { return first <= last; }

  /// Whether what bears this stamp belongs to the map that ends. Where the clock ran back, to
  /// whichever scan it is nearer.
  bool isBefore(const ros::Time& stamp) const {
    if (!clockRanBack()) return stamp < first;
    const double time_s = stamp.toSec();  // a difference of stamps far apart would throw
    return std::abs(time_s - last.toSec()) <= std::abs(time_s - first.toSec());
  }
};

}  // namespace hymm
