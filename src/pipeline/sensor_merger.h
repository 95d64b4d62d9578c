#pragma once

#include <cstddef>
#include <deque>
#include <limits>
#include <vector>

#include "common/config.h"
#include "pipeline/sensor_event.h"

namespace hymm::core {

struct SensorMergerConfig {
  double motion_wait_s = 0.1;   ///< longest wait of a scan for motion past its stamp
  double clock_jump_s = 1.0;    ///< a step back by more than this may be a new recording
  int clock_jump_events = 3;    ///< events in a row, all from the past, that make it one

  void describe(ConfigSchema& schema);
};

/// Merges sensor streams by stamp, so that a filter sees the same order live and offline. Motion
/// inputs are kept until a scan, observation set or fix needs them; that one is released with the
/// motion up to its stamp as soon as motion at or past its stamp has come, or when it has waited
/// long enough. Events older than what was released are dropped and counted; a run of them, all
/// older by more than clock_jump_s, is a new recording and yields ClockReset first.
class SensorMerger {
 public:
  struct Counts {
    std::size_t out_of_order = 0;      ///< dropped: older than what was released
    std::size_t without_motion = 0;    ///< released although no motion past their stamp came
    std::size_t clock_resets = 0;
  };

  explicit SensorMerger(const SensorMergerConfig& config);

  /// Adds an event that arrived at `now_s` (any steady clock; unused offline). Stamps that are not
  /// finite are the caller's to refuse.
  void push(SensorEvent event, double now_s = 0.0);

  /// Events that can be processed now, in order. With `now_s` infinite (offline) nothing times out.
  std::vector<SensorEvent> popReady(double now_s = -std::numeric_limits<double>::infinity());

  /// Everything that is left, in order: the end of a recording.
  std::vector<SensorEvent> flush();

  /// Forgets all events and times; counts stay.
  void reset();

  const Counts& counts() const { return counts_; }

 private:
  struct Pending {
    SensorEvent event;
    double time_s;
    double arrival_s;
  };

  void insert(Pending pending);
  void acceptJump();
  void release(std::vector<SensorEvent>& released);

  SensorMergerConfig config_;
  std::deque<Pending> motion_;
  std::deque<Pending> measurements_;
  std::vector<Pending> suspects_;  ///< events from the past that may open a new recording
  bool jump_accepted_ = false;
  double newest_motion_s_ = -std::numeric_limits<double>::infinity();
  double newest_s_ = -std::numeric_limits<double>::infinity();
  double released_s_ = -std::numeric_limits<double>::infinity();
  Counts counts_;
};

}  // namespace hymm::core
