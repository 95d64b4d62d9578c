#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include <hymm/FilterHealth.h>
#include <hymm/FilterPose.h>

#include "pipeline/filter_life.h"

namespace hymm {

/// What a filter told of one scan.
struct FilterAnswer {
  FilterPose pose;
  FilterHealth health;

  core::FilterCounters counters() const { return {pose.map_version, health.resets, health.scans}; }
};

/// Brings the pose and the health of a scan, which come on two topics, together by their stamp. One
/// whose other half does not come is passed over with the next pair, whatever its stamp: a clock
/// may run back, and a stamp may be wrong.
class FilterPairing {
 public:
  void add(const FilterPose& pose) { poses_.push_back(pose); }
  void add(const FilterHealth& health) { healths_.push_back(health); }

  /// The next scan of which both have come, in the order in which they came.
  std::optional<FilterAnswer> next();

  /// Poses without health and the other way: those of the moment in which one began to listen.
  std::size_t unpaired() const { return unpaired_; }

 private:
  template <class Message>
  void bound(std::deque<Message>& waiting);

  std::deque<FilterPose> poses_;      ///< whose health has not come
  std::deque<FilterHealth> healths_;  ///< whose pose has not come
  std::size_t unpaired_ = 0;
};

}  // namespace hymm
