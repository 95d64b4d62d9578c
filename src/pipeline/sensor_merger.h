#pragma once

#include <cstddef>
#include <deque>
#include <limits>
#include <vector>

#include "common/config.h"
#include "pipeline/sensor_event.h"

namespace hymm::core {

struct SensorMergerConfig {
  double motion_wait_s = 0.1;
  double motion_delay_s = 0.0;
  double clock_jump_s = 1.0;
  int clock_jump_events = 3;

  void describe(ConfigSchema& schema);
};

/// Merges sensor streams by stamp, so that a filter sees the same order live and offline. Motion
/// inputs are kept until a scan, observation set or fix needs them; that one is released, behind
/// the motion up to its stamp, as soon as motion at or past its end (a scan's last beam; else the
/// stamp) has come, or when it has waited long enough. A scan that takes its time is told the
/// motion meanwhile. Motion inputs get the stamps at which the vehicle does what they say. Events
/// older than what was released are dropped and counted; a run of them, all older than the newest
/// by more than clock_jump_s, is a new recording: what is left of the old one comes first, then a
/// ClockReset, then the new events.
class SensorMerger {
 public:
  struct Counts {
    std::size_t out_of_order = 0;    ///< dropped: older than what was released
    std::size_t without_motion = 0;  ///< released although no motion at or past their end came
    std::size_t clock_resets = 0;
  };

  explicit SensorMerger(const SensorMergerConfig& config);

  /// Adds an event that arrived at `now_s` on any steady clock; offline nothing times out and it is
  /// not needed. Stamps that are not finite are the caller's to refuse.
  void push(SensorEvent event, double now_s = 0.0);

  /// Events that can be processed now, in order.
  std::vector<SensorEvent> popReady(double now_s = -std::numeric_limits<double>::infinity());

  /// Everything that is left, in order: the end of a recording.
  std::vector<SensorEvent> flush();

  /// Forgets all events and times; counts stay.
  void reset();

  const Counts& counts() const { return counts_; }

 private:
  struct Pending {
    SensorEvent event;
    double time_s, end_s;
    double arrival_s;
  };

  void accept(Pending pending);
  void acceptClockJump();
  void releaseFirstMeasurement();
  void releaseMotionUpTo(double time_s);
  void tellMotionMeanwhile(ScanEvent& scan) const;
  void releaseAll();
  void forgetTimes();

  SensorMergerConfig config_;
  std::deque<Pending> motion_;
  std::deque<Pending> measurements_;
  std::vector<Pending> suspects_;  ///< the last events, all from the past: perhaps a new recording
  std::vector<SensorEvent> ready_;
  double newest_motion_s_ = -std::numeric_limits<double>::infinity();
  double newest_s_ = -std::numeric_limits<double>::infinity();
  double released_s_ = -std::numeric_limits<double>::infinity();
  Counts counts_;
};

}  // namespace hymm::core
