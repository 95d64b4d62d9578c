#pragma once

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace hymm::core {

/// Events of one source, in a row, whose stamps are far from the newest one that is believed: each
/// may be stray, but if others go on from it, the source's clock has jumped. `Event` has a member
/// `time_s`.
template <class Event>
class SuspectRun {
 public:
  /// Adds an event. Returns those before, if this one is nearer to `newest_s`, which is believed,
  /// than to them: then they were stray.
  std::vector<Event> add(Event event, double newest_s) {
    std::vector<Event> stray;
    if (!goesOn(event.time_s, newest_s)) stray = take();
    events_.push_back(std::move(event));
    return stray;
  }

  /// Empties the run.
  std::vector<Event> take() { return std::exchange(events_, {}); }

  bool empty() const { return events_.empty(); }
  std::size_t size() const { return events_.size(); }
  double first_s() const { return events_.front().time_s; }
  double last_s() const { return events_.back().time_s; }

 private:
  bool goesOn(double time_s, double newest_s) const {
    return events_.empty() || std::abs(time_s - last_s()) < std::abs(time_s - newest_s);
  }

  std::vector<Event> events_;
};

}  // namespace hymm::core
