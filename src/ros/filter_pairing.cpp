#include "ros/filter_pairing.h"

namespace hymm {

std::optional<FilterAnswer> FilterPairing::next() {
  while (!poses_.empty() && !healths_.empty()) {
    const ros::Time pose_stamp = poses_.front().header.stamp;
    const ros::Time health_stamp = healths_.front().header.stamp;
    if (pose_stamp == health_stamp) {
      const FilterAnswer answer{poses_.front(), healths_.front()};
      poses_.pop_front();
      healths_.pop_front();
      return answer;
    }
    ++unpaired_;
    if (pose_stamp < health_stamp) {
      poses_.pop_front();
    } else {
      healths_.pop_front();
    }
  }
  return std::nullopt;
}

}  // namespace hymm
