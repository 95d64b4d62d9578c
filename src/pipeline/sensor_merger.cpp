#include "pipeline/sensor_merger.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hymm::core {
namespace {

// Motion that no scan asks for is passed on beyond this, so that memory stays bounded.
constexpr std::size_t kMaxPendingMotion = 4096;
constexpr std::size_t kMaxPendingScans = 4096;
constexpr std::size_t kMaxPendingFixes = 4096;
constexpr std::size_t kMaxSuspects = 1000;  // as many as clock_jump_events can ask for
// By stamps. In a fast playback topics may be apart by seconds: for that long a clock that runs
// back waits for what the other one says.
constexpr double kTestimony_s = 5.0;
/// Inserts by time, behind events of the same time.
template <class Queue, class Pending>
void insertByTime(Queue& queue, Pending pending) {
  auto place = queue.end();
  while (place != queue.begin() && std::prev(place)->time_s > pending.time_s) --place;
  queue.insert(place, std::move(pending));
}

void delay(MotionInput& input, double delay_s) {
  std::visit([&](auto& told) { told.time_s += delay_s; }, input);
  auto* const twist = std::get_if<TwistInput>(&input);
  if (twist != nullptr && twist->until_s) *twist->until_s += delay_s;
}

bool isMean(const SensorEvent& event) { return endOf(event) > timeOf(event); }

/// Leaves of a mean what is not over at `time_s`.
void cutOff(SensorEvent& event, double time_s) {
  auto& twist = std::get<TwistInput>(std::get<MotionInput>(event));
  twist.time_s = std::max(twist.time_s, time_s);
}

bool isFix(const SensorEvent& event) { return std::holds_alternative<GpsFix>(event); }

}  // namespace

void SensorMergerConfig::describe(ConfigSchema& schema) {
  schema.number(
      "motion_wait_s", motion_wait_s, Range::between(0.0, 10.0),
      "a scan goes without motion at or past its last beam once no motion has come for so long "
      "(live only)");
  schema.number(
      "motion_delay_s", motion_delay_s, Range::between(0.0, 5.0),
      "from a motion input's stamp to when the vehicle moves so: of odometry that is what "
      "the drive was told, or what a slow filter made of it");
  schema.number("clock_jump_s", clock_jump_s, Range::positive(),
                "events farther than this from the newest, before or after, are not believed until "
                "others confirm them; longer than the motion input's period");
  schema.integer("clock_jump_events", clock_jump_events, Range::between(1, 1000),
                 "how many such events in a row mean a new recording, or a gap in this one");
}

SensorMerger::SensorMerger(const SensorMergerConfig& config) : config_(config) {}

void SensorMerger::push(SensorEvent event, double now_s) {
  now_s_ = now_s;
  auto* const motion = std::get_if<MotionInput>(&event);
  if (motion != nullptr) {
    delay(*motion, config_.motion_delay_s);
    motion_arrival_s_ = now_s;
    ++motion_arrived_;
  }
  const double end_s = endOf(event);
  const double time_s = motion != nullptr ? end_s : timeOf(event);
  take({std::move(event), time_s, end_s, now_s, motion_arrived_});
}

// --- Which stamps to believe -----------------------------------------------------------------

bool SensorMerger::isMotion(const Pending& pending) {
  return std::holds_alternative<MotionInput>(pending.event);
}

double SensorMerger::newest_s() const {
  return std::max(motion_clock_.newest_s, scan_clock_.newest_s);
}

/// Compared with its own clock when it is late: live, one topic may come later than another by
/// seconds of a fast playback, but each is in order.
bool SensorMerger::fits(const Clock& clock, double time_s) const {
  const bool is_first = newest_s() == kNever;
  return time_s >= clock.newest_s - config_.clock_jump_s &&
         (is_first || time_s <= newest_s() + config_.clock_jump_s);
}

bool SensorMerger::isReached(const Clock& clock) const {
  return !clock.suspects.empty() && fits(clock, clock.suspects.first_s());
}

bool SensorMerger::runsBack(const Clock& clock) {
  return !clock.suspects.empty() && clock.suspects.last_s() < clock.newest_s;
}

void SensorMerger::take(Pending pending) {
  if (isFix(pending.event)) {
    takeFix(std::move(pending));
    return;
  }
  Clock& clock = clockOf(pending);
  if (!fits(clock, pending.time_s)) {
    suspect(clock, std::move(pending));
    return;
  }
  drop(clock.suspects.take());
  Clock& other = otherThan(clock);
  other.contradicted = true;
  believe(std::move(pending));
  if (isReached(other)) believeSuspects(other);
}

/// A fix ahead of the scans waits for them. One that comes later with an earlier stamp says that
/// those far beyond it were stray.
void SensorMerger::takeFix(Pending fix) {
  if (fix.time_s < released_s_) {
    drop(fix);
    return;
  }
  dropBeyond(fixes_, fix.time_s + config_.clock_jump_s);
  insertByTime(fixes_, std::move(fix));
  if (fixes_.size() <= kMaxPendingFixes) return;
  drop(fixes_.back());
  fixes_.pop_back();
}

void SensorMerger::believe(Pending pending) {
  Clock& clock = clockOf(pending);
  clock.newest_s = std::max(clock.newest_s, pending.time_s);
  pending.arrival_s = now_s_;  // what was held could not be used before: its wait begins now
  queue(std::move(pending));
}

void SensorMerger::believeSuspects(Clock& clock) {
  for (Pending& pending : clock.suspects.take()) believe(std::move(pending));
}

void SensorMerger::suspect(Clock& clock, Pending pending) {
  const std::vector<Pending> stray = clock.suspects.add(std::move(pending), clock.newest_s);
  drop(stray);
  if (clock.suspects.size() == 1) clock.contradicted = false;
  if (runsBack(clock)) {
    judgeRunBack(clock);
    return;
  }
  Clock& other = otherThan(clock);
  const bool agree = areAheadTogether(clock, other);
  const std::size_t size = clock.suspects.size() + (agree ? other.suspects.size() : 0);
  if (size < static_cast<std::size_t>(config_.clock_jump_events)) return;
  believeSuspects(clock);
  if (agree || isReached(other)) believeSuspects(other);
}

/// As behind a gap in the recording: what both clocks say is not stray.
bool SensorMerger::areAheadTogether(const Clock& clock, const Clock& other) const {
  return !other.suspects.empty() && !runsBack(other) &&
         std::abs(clock.suspects.last_s() - other.suspects.last_s()) <= config_.clock_jump_s;
}

void SensorMerger::judgeRunBack(Clock& clock) {
  const Clock& other = otherThan(clock);
  const SuspectRun<Pending>& run = clock.suspects;
  const std::size_t size = run.size() + (runsBack(other) ? other.suspects.size() : 0);
  if (size < static_cast<std::size_t>(config_.clock_jump_events)) return;
  const bool is_where_the_other_is = run.last_s() >= other.newest_s - config_.clock_jump_s &&
                                     run.last_s() <= other.newest_s + kTestimony_s;
  const bool other_is_silent = other.newest_s < clock.newest_s - kTestimony_s;
  const bool time_is_over =
      run.last_s() - run.first_s() > kTestimony_s || run.size() >= kMaxSuspects;
  if (runsBack(other)) {
    beginAnew();
  } else if (is_where_the_other_is || (time_is_over && clock.contradicted)) {
    putBack(clock);
  } else if (other_is_silent || time_is_over) {
    beginAnew();
  }
}

/// Its own clock erred, or errs from here on: the recording is the same.
void SensorMerger::putBack(Clock& clock) {
  std::deque<Pending>& queue = &clock == &motion_clock_ ? motion_ : scans_;
  dropBeyond(queue, clock.suspects.last_s() + config_.clock_jump_s);
  clock.newest_s = kNever;
  believeSuspects(clock);
}

void SensorMerger::dropBeyond(std::deque<Pending>& queue, double time_s) {
  while (!queue.empty() && queue.back().time_s > time_s) {
    drop(queue.back());
    queue.pop_back();
  }
}

void SensorMerger::beginAnew() {
  std::vector<Pending> first_events;
  for (Clock* clock : {&motion_clock_, &scan_clock_}) {
    if (!runsBack(*clock)) continue;
    for (Pending& pending : clock->suspects.take()) first_events.push_back(std::move(pending));
  }
  dropSuspects();
  releaseAll();
  forgetTimes();
  ++counts_.clock_resets;
  double first_s = timeOf(first_events.front().event);
  for (const Pending& pending : first_events) {
    first_s = std::min(first_s, timeOf(pending.event));
  }
  ready_.emplace_back(ClockReset{first_s});
  for (Pending& pending : first_events) believe(std::move(pending));
}

void SensorMerger::dropSuspects() {
  drop(motion_clock_.suspects.take());
  drop(scan_clock_.suspects.take());
}

void SensorMerger::drop(const Pending& pending) {
  ++counts_.out_of_order;
  if (!isMotion(pending) && !isFix(pending.event)) ++counts_.dropped_scans;
}

void SensorMerger::drop(const std::vector<Pending>& all) {
  for (const Pending& pending : all) drop(pending);
}

// --- In which order to release them -----------------------------------------------------------

void SensorMerger::queue(Pending pending) {
  const bool is_mean = isMotion(pending) && isMean(pending.event);
  if (pending.time_s < released_s_ || (is_mean && pending.time_s == released_s_)) {
    drop(pending);
    return;
  }
  if (is_mean) cutOff(pending.event, released_s_);
  std::deque<Pending>& queue = isMotion(pending) ? motion_ : scans_;
  insertByTime(queue, std::move(pending));
  boundScans();
}

/// Scans that motion goes on without reaching are of another clock; where there is no more motion
/// they go on without.
void SensorMerger::boundScans() {
  while (scans_.size() > kMaxPendingScans) {
    if (scans_.front().motion_before == motion_arrived_) {
      releaseFirstScan();
    } else {
      drop(scans_.back());
      scans_.pop_back();
    }
  }
}

std::vector<SensorEvent> SensorMerger::popReady(double now_s) {
  while (!scans_.empty()) {
    const Pending& first = scans_.front();
    if (motion_clock_.newest_s < first.end_s && !hasWaited(first, now_s)) break;
    releaseFirstScan();
  }
  if (motion_.size() > kMaxPendingMotion) {
    double time_s = timeOf(motion_[motion_.size() - kMaxPendingMotion].event);
    if (!scans_.empty()) time_s = std::min(time_s, scans_.front().time_s);
    releaseFixesUpTo(time_s);
    releaseMotionUpTo(time_s);
  }
  return std::exchange(ready_, {});
}

/// As long as motion comes it is on its way to the scan, be it late or of another clock: what went
/// past it could not be used any more.
bool SensorMerger::hasWaited(const Pending& scan, double now_s) const {
  return now_s - std::max(scan.arrival_s, motion_arrival_s_) > config_.motion_wait_s;
}

std::vector<SensorEvent> SensorMerger::flush() {
  dropSuspects();
  releaseAll();
  return std::exchange(ready_, {});
}

void SensorMerger::reset() {
  motion_.clear();
  scans_.clear();
  fixes_.clear();
  motion_clock_ = scan_clock_ = Clock();
  ready_.clear();
  forgetTimes();
}

void SensorMerger::releaseFirstScan() {
  Pending first = std::move(scans_.front());
  scans_.pop_front();
  if (motion_clock_.newest_s < first.end_s) ++counts_.without_motion;
  releaseFixesUpTo(first.time_s);
  releaseMotionUpTo(first.time_s);
  // A mean that begins with the scan may have come or not; what a scan without length is told must
  // not depend on it. One that takes its time has waited for it.
  if (first.end_s > first.time_s) releaseMeanFrom(first.time_s);
  released_s_ = std::max(released_s_, first.time_s);
  auto* scan = std::get_if<ScanEvent>(&first.event);
  if (scan != nullptr && first.end_s > first.time_s) tellMotionMeanwhile(*scan);
  ready_.push_back(std::move(first.event));
}

void SensorMerger::tellMotionMeanwhile(ScanEvent& scan) const {
  const double end_s = scan.scan.time_s + scan.scan.sweep_s();
  for (const Pending& pending : motion_) {
    const auto& input = std::get<MotionInput>(pending.event);
    if (timeOf(input) > end_s) break;
    if (isFinite(input)) scan.motion_meanwhile.push_back(input);
  }
}

void SensorMerger::releaseFixesUpTo(double time_s) {
  while (!fixes_.empty() && fixes_.front().time_s <= time_s) {
    releaseMotionUpTo(fixes_.front().time_s);
    ready_.push_back(std::move(fixes_.front().event));
    fixes_.pop_front();
  }
}

/// Inputs up to the time, and means that begin before it.
void SensorMerger::releaseMotionUpTo(double time_s) {
  while (!motion_.empty()) {
    const SensorEvent& first = motion_.front().event;
    if (timeOf(first) > time_s || (isMean(first) && timeOf(first) == time_s)) break;
    releaseFirstMotion();
  }
}

void SensorMerger::releaseMeanFrom(double time_s) {
  if (!motion_.empty() && timeOf(motion_.front().event) == time_s) releaseFirstMotion();
}

void SensorMerger::releaseFirstMotion() {
  released_s_ = std::max(released_s_, timeOf(motion_.front().event));
  ready_.push_back(std::move(motion_.front().event));
  motion_.pop_front();
}

/// Fixes beyond the end of the drive cannot be used: nothing tells where the vehicle was.
void SensorMerger::releaseAll() {
  while (!scans_.empty()) releaseFirstScan();
  dropBeyond(fixes_, newest_s() + config_.clock_jump_s);
  releaseFixesUpTo(std::numeric_limits<double>::infinity());
  releaseMotionUpTo(std::numeric_limits<double>::infinity());
}

void SensorMerger::forgetTimes() {
  motion_clock_.newest_s = scan_clock_.newest_s = released_s_ = kNever;
}

}  // namespace hymm::core
