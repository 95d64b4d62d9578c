#include "cekf/local_state_ring.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {
namespace {

// Stamps that have gone through a message or a file may differ by rounding.
constexpr double kSameStamp_s = 1e-4;

// Parts of the ring between two memories: fewer cost memory for scans that are not asked for, more
// cost copies.
constexpr double kParts = 4.0;

bool isSame(double a_s, double b_s) { return std::abs(a_s - b_s) < kSameStamp_s; }

bool isScan(const SensorEvent& event) {
  return std::holds_alternative<ScanEvent>(event) || std::holds_alternative<ObservationSet>(event);
}

}  // namespace

void LocalStateRing::setDuration(double duration_s) {
  duration_s_ = std::max(duration_s, 0.0);
  if (!isKept()) clear();
}

void LocalStateRing::add(const SensorEvent& event) {
  if (!memories_.empty()) events_.push_back({std::make_shared<const SensorEvent>(event), false});
}

bool LocalStateRing::noteScan(double time_s) {
  if (!isKept()) return false;
  if (memories_.empty()) return true;
  const auto scan = std::find_if(events_.rbegin(), events_.rend(),
                                 [](const KeptEvent& e) { return isScan(*e.event); });
  if (scan != events_.rend() && timeOf(*scan->event) == time_s) scan->is_scan = true;
  const auto age_s = [&](const KeptMemory& kept) {
    return time_s - kept.memory->scan_clock.last_s();
  };
  while (memories_.size() > 1 && age_s(memories_[1]) >= duration_s_ - kSameStamp_s) dropOldest();
  return age_s(memories_.back()) >= duration_s_ / kParts - kSameStamp_s;
}

void LocalStateRing::remember(Memory memory) {
  memories_.push_back({std::move(memory), endOfEvents()});
}

std::size_t LocalStateRing::scanCount() const {
  if (memories_.empty()) return 0;
  return 1 + static_cast<std::size_t>(std::count_if(events_.begin(), events_.end(),
                                                    [](const KeptEvent& e) { return e.is_scan; }));
}

std::optional<LocalStateRing::Way> LocalStateRing::findWay(double time_s) const {
  const auto later = std::find_if(memories_.begin(), memories_.end(), [&](const KeptMemory& m) {
    return m.memory->scan_clock.last_s() > time_s && !isSame(m.memory->scan_clock.last_s(), time_s);
  });
  if (later == memories_.begin()) return std::nullopt;
  const KeptMemory& from = *std::prev(later);
  Way way{from.memory, {}, {}, from.next_event};
  bool found = isSame(from.memory->scan_clock.last_s(), time_s);
  for (std::size_t i = from.next_event; i < endOfEvents(); ++i) {
    const KeptEvent& kept = event(i);
    (found ? way.since : way.to_scan).push_back(kept.event);
    if (found || !kept.is_scan || !isSame(timeOf(*kept.event), time_s)) continue;
    found = true;
    way.next_event = i + 1;
  }
  if (!found) return std::nullopt;
  return way;
}

void LocalStateRing::goBackTo(const Way& way, Memory memory) {
  while (!memories_.empty() && memories_.back().next_event >= way.next_event) memories_.pop_back();
  for (std::size_t i = way.next_event; i < endOfEvents(); ++i) {
    events_[i - first_event_].is_scan = false;
  }
  memories_.push_back({std::move(memory), way.next_event});
}

std::size_t LocalStateRing::dropScansBefore(double time_s) {
  if (memories_.empty()) return 0;
  const std::size_t newest = memories_.back().next_event;
  std::size_t dropped = 0;
  for (std::size_t i = newest - first_event_; i < events_.size();) {
    if (timeOf(*events_[i].event) >= time_s) break;
    if (!isScan(*events_[i].event)) {
      ++i;
      continue;
    }
    events_.erase(events_.begin() + static_cast<std::ptrdiff_t>(i));
    ++dropped;
  }
  return dropped;
}

void LocalStateRing::dropOldest() {
  memories_.pop_front();
  const std::size_t end = memories_.empty() ? endOfEvents() : memories_.front().next_event;
  events_.erase(events_.begin(), events_.begin() + static_cast<std::ptrdiff_t>(end - first_event_));
  first_event_ = end;
}

void LocalStateRing::clear() {
  memories_.clear();
  first_event_ = endOfEvents();
  events_.clear();
}

std::optional<LocalStateSpan> LocalStateRing::span() const {
  if (memories_.empty()) return std::nullopt;
  LocalStateSpan span;
  span.oldest_s = memories_.front().memory->scan_clock.last_s();
  span.newest_s = memories_.back().memory->scan_clock.last_s();
  for (const KeptEvent& kept : events_) {
    if (kept.is_scan) span.newest_s = std::max(span.newest_s, timeOf(*kept.event));
  }
  span.scans = scanCount();
  for (const KeptMemory& kept : memories_) span.bytes += kept.memory->filter.bytes();
  return span;
}

}  // namespace hymm::core
