#pragma once

#include <cstddef>
#include <deque>
#include <limits>
#include <vector>

#include "common/config.h"
#include "common/suspect_run.h"
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
/// inputs are kept until a scan or observation set (called scan below) needs them; that one is
/// released, behind the motion and the GPS fixes up to its stamp, as soon as motion at or past its
/// end (a scan's last beam; else the stamp) has come, or when it has waited long enough. A scan
/// that takes its time is told the motion meanwhile. Motion inputs get the stamps at which the
/// vehicle does what they say. Events older than what was released are dropped and counted; of a
/// mean over an interval (TwistInput::until_s) the part counts that is not over.
///
/// Motion and scans have a clock each. An event farther from its clock than clock_jump_s is held,
/// not believed, until it is clear what it is:
/// - one that fits the clock follows: what was held is stray, and dropped;
/// - ahead of both clocks, and clock_jump_events in a row say so, of its kind, or of both kinds
/// with
///   stamps that agree, or the other clock gets there: a gap in the recording, or a clock put
///   forward; the events are used;
/// - behind, and the other clock runs back too, or is silent: a new recording. What is left of the
///   old one comes first, then a ClockReset, then the events held;
/// - behind, while the other clock goes on, or is there already: its own clock was put back. The
///   events are used as far as they are not older than what was released.
/// GPS fixes have no say in any of it: they wait for the scans to get to their stamps.
class SensorMerger {
 public:
  struct Counts {
    std::size_t out_of_order = 0;    ///< dropped: stray, or older than what was released
    std::size_t dropped_scans = 0;   ///< scans among them
    std::size_t without_motion = 0;  ///< released although no motion at or past their end came
    std::size_t clock_resets = 0;
  };

  explicit SensorMerger(const SensorMergerConfig& config);

  /// Adds an event that arrived at `now_s` on any steady clock; offline nothing times out and it is
  /// not needed. Stamps that are not finite are the caller's to refuse.
  void push(SensorEvent event, double now_s = 0.0);

  /// Events that can be processed now, in order.
  std::vector<SensorEvent> popReady(double now_s = -std::numeric_limits<double>::infinity());

  /// Everything that is left and believed, in order: the end of a recording.
  std::vector<SensorEvent> flush();

  /// Forgets all events and times; counts stay.
  void reset();

  const Counts& counts() const { return counts_; }

 private:
  static constexpr double kNever = -std::numeric_limits<double>::infinity();

  struct Pending {
    SensorEvent event;
    double time_s;  ///< its stamp; of motion told as a mean, the end
    double end_s;
    double arrival_s;
    std::size_t motion_before;  ///< motion inputs that arrived earlier
  };

  struct Clock {
    double newest_s = kNever;      ///< that is believed
    SuspectRun<Pending> suspects;  ///< held
    bool contradicted = false;     ///< since these began the other clock has gone on
  };

  Clock& clockOf(const Pending& pending) { return isMotion(pending) ? motion_clock_ : scan_clock_; }
  Clock& otherThan(const Clock& clock) {
    return &clock == &motion_clock_ ? scan_clock_ : motion_clock_;
  }
  static bool isMotion(const Pending& pending);
  double newest_s() const;
  bool fits(const Clock& clock, double time_s) const;
  bool isReached(const Clock& clock) const;
  static bool runsBack(const Clock& clock);

  void take(Pending pending);
  void takeFix(Pending fix);
  void believe(Pending pending);
  void believeSuspects(Clock& clock);
  void suspect(Clock& clock, Pending pending);
  bool areAheadTogether(const Clock& clock, const Clock& other) const;
  void judgeRunBack(Clock& clock);
  void putBack(Clock& clock);
  void dropBeyond(std::deque<Pending>& queue, double time_s);
  void beginAnew();
  void dropSuspects();
  void drop(const Pending& pending);
  void drop(const std::vector<Pending>& all);

  void queue(Pending pending);
  void boundScans();
  bool hasWaited(const Pending& scan, double now_s) const;
  void releaseFirstScan();
  void releaseFixesUpTo(double time_s);
  void releaseMotionUpTo(double time_s);
  void releaseMeanFrom(double time_s);
  void releaseFirstMotion();
  void tellMotionMeanwhile(ScanEvent& scan) const;
  void releaseAll();
  void forgetTimes();

  SensorMergerConfig config_;
  Clock motion_clock_, scan_clock_;
  std::deque<Pending> motion_, scans_, fixes_;
  std::vector<SensorEvent> ready_;
  double released_s_ = kNever;
  double now_s_ = 0.0;
  double motion_arrival_s_ = kNever;
  std::size_t motion_arrived_ = 0;
  Counts counts_;
};

}  // namespace hymm::core
