#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "common/suspect_run.h"

namespace hymm::core {

/// Tells stray stamps of a single source from jumps of its clock. An event whose stamp is farther
/// from the newest than `jump_s`, to either side, is held until `followers` in a row, itself
/// included, say the same; one that fits what was believed before says that those held were stray.
/// The first event is believed. `Event` has a member `time_s`.
template <class Event>
class JumpFilter {
 public:
  struct Answer {
    bool ran_back = false;      ///< the events begin another recording
    std::vector<Event> events;  ///< to be used, in the order in which they came
  };

  JumpFilter(double jump_s, int followers)
      : jump_s_(jump_s), followers_(static_cast<std::size_t>(followers)) {}

  Answer push(Event event) {
    if (!knows_newest_ || std::abs(event.time_s - newest_s_) <= jump_s_) {
      strays_ += suspects_.take().size();
      return believe(false, {std::move(event)});
    }
    strays_ += suspects_.add(std::move(event), newest_s_).size();
    if (suspects_.size() < followers_) return {};
    const bool ran_back = suspects_.last_s() < newest_s_;
    return believe(ran_back, suspects_.take());
  }

  /// Events that were not used.
  std::size_t strays() const { return strays_; }

 private:
  Answer believe(bool ran_back, std::vector<Event> events) {
    if (ran_back || !knows_newest_) newest_s_ = events.front().time_s;
    for (const Event& event : events) newest_s_ = std::max(newest_s_, event.time_s);
    knows_newest_ = true;
    return {ran_back, std::move(events)};
  }

  double jump_s_;
  std::size_t followers_;
  SuspectRun<Event> suspects_;
  bool knows_newest_ = false;
  double newest_s_ = 0.0;
  std::size_t strays_ = 0;
};

}  // namespace hymm::core
