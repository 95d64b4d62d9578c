#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "cekf/active_area.h"
#include "cekf/gps_datum.h"
#include "cekf/landmark_life_cycle.h"
#include "cekf/local_state.h"
#include "cekf/place_finder.h"
#include "cekf/resumption.h"
#include "cekf/scan_clock.h"
#include "cekf/scan_update.h"
#include "cekf/vehicle_state.h"
#include "pipeline/sensor_event.h"

namespace hymm::core {

/// Everything of a filter that goes back with it, but what its global updates have carried out.
struct FilterMemory {
  ScanClock scan_clock;
  VehicleState vehicle;
  LocalState filter;
  std::optional<GpsDatum> gps;
  LandmarkLifeCycle life_cycle;
  ScanUpdate scan_update;
  PlaceFinder place_finder;
  ActiveArea area;
  std::size_t settled_updates = 0;
};

/// The last scans of a filter, each of which can be gone back to: memories at every few of them,
/// and all events since the first of them. What lies between two memories is reached by replaying.
class LocalStateRing {
 public:
  using Memory = std::shared_ptr<const FilterMemory>;
  using Events = std::vector<std::shared_ptr<const SensorEvent>>;

  /// A way to a scan: a memory, and the events that lead from there to the scan, and on to now.
  struct Way {
    Memory memory;
    Events to_scan, since;
    std::size_t next_event = 0;  ///< the first since, counted from the start
  };

  /// Keeps the scans of the last `duration_s`, by stamps, from now on; 0: nothing.
  void setDuration(double duration_s);
  bool isKept() const { return duration_s_ > 0.0; }

  /// Events in their order, before they are processed.
  void add(const SensorEvent& event);
  /// A scan has been processed. Whether it is time to remember().
  bool noteScan(double time_s);
  void remember(Memory memory);

  /// Nothing if no such scan is kept.
  std::optional<Way> findWay(double time_s) const;
  /// Forgets what came after the scan at the end of `way`, but for the events. `memory`: of it.
  void goBackTo(const Way& way, Memory memory);
  /// Gives up memories for which `isReachable` is false; returns how many scans went with them.
  template <typename Predicate>
  std::size_t giveUp(Predicate isReachable) {
    const std::size_t before = scanCount();
    while (!memories_.empty() && !isReachable(*memories_.front().memory)) dropOldest();
    return before - scanCount();
  }
  /// Drops scans older than this, not motion.
  std::size_t dropScansBefore(double time_s);
  void clear();

  /// The oldest memory; null if there is none.
  Memory oldest() const { return memories_.empty() ? nullptr : memories_.front().memory; }
  std::optional<LocalStateSpan> span() const;

 private:
  struct KeptMemory {
    Memory memory;
    std::size_t next_event = 0;  ///< first event after it, counted from the start
  };
  struct KeptEvent {
    std::shared_ptr<const SensorEvent> event;
    bool is_scan = false;  ///< that was processed
  };

  std::size_t scanCount() const;
  void dropOldest();
  const KeptEvent& event(std::size_t number) const { return events_[number - first_event_]; }
  std::size_t endOfEvents() const { return first_event_ + events_.size(); }

  double duration_s_ = 0.0;
  std::deque<KeptMemory> memories_;
  std::deque<KeptEvent> events_;
  std::size_t first_event_ = 0;
};

}  // namespace hymm::core
