#include "pipeline/sensor_merger.h"

#include <algorithm>
#include <utility>

namespace hymm::core {
namespace {

// Motion that no measurement asks for is passed on beyond this, so that memory stays bounded.
constexpr std::size_t kMaxPendingMotion = 4096;

/// Inserts by time, behind events of the same time.
template <class Queue, class Pending>
void insertByTime(Queue& queue, Pending pending) {
  auto place = queue.end();
  while (place != queue.begin() && std::prev(place)->time_s > pending.time_s) --place;
  queue.insert(place, std::move(pending));
}

void delay(MotionInput& input, double delay_s) {
  std::visit([&](auto& told) { told.time_s += delay_s; }, input);
}

}  // namespace

void SensorMergerConfig::describe(ConfigSchema& schema) {
  schema.number("motion_wait_s", motion_wait_s, Range::between(0.0, 10.0),
                "longest wait of a scan for motion at or past its last beam (live only)");
  schema.number(
      "motion_delay_s", motion_delay_s, Range::between(0.0, 5.0),
      "from a motion input's stamp to when the vehicle moves so: of odometry that is what "
      "the drive was told, or what a slow filter made of it");
  schema.number("clock_jump_s", clock_jump_s, Range::positive(),
                "events older than the newest by more than this may belong to a new recording");
  schema.integer("clock_jump_events", clock_jump_events, Range::between(1, 1000),
                 "how many such events in a row make it a new recording");
}

SensorMerger::SensorMerger(const SensorMergerConfig& config) : config_(config) {}

void SensorMerger::push(SensorEvent event, double now_s) {
  auto* const motion = std::get_if<MotionInput>(&event);
  const bool is_motion = motion != nullptr;
  if (is_motion) delay(*motion, config_.motion_delay_s);
  const double time_s = timeOf(event);
  const double end_s = endOf(event);
  Pending pending{std::move(event), time_s, end_s, now_s};
  // Compared within its kind: live, one topic may come later than another by seconds of a fast
  // playback, but each is in order.
  const double newest_s = is_motion ? newest_motion_s_ : newest_s_;
  if (time_s < newest_s - config_.clock_jump_s) {
    suspects_.push_back(std::move(pending));
    if (suspects_.size() >= static_cast<std::size_t>(config_.clock_jump_events)) acceptClockJump();
    return;
  }
  counts_.out_of_order += suspects_.size();
  suspects_.clear();
  accept(std::move(pending));
}

void SensorMerger::accept(Pending pending) {
  if (pending.time_s < released_s_) {
    ++counts_.out_of_order;
    return;
  }
  if (std::holds_alternative<MotionInput>(pending.event)) {
    newest_motion_s_ = std::max(newest_motion_s_, pending.time_s);
    insertByTime(motion_, std::move(pending));
  } else {
    newest_s_ = std::max(newest_s_, pending.time_s);
    insertByTime(measurements_, std::move(pending));
  }
}

void SensorMerger::acceptClockJump() {
  releaseAll();
  forgetTimes();
  ++counts_.clock_resets;
  std::vector<Pending> first_events = std::exchange(suspects_, {});
  ready_.emplace_back(ClockReset{first_events.front().time_s});
  for (Pending& pending : first_events) accept(std::move(pending));
}

std::vector<SensorEvent> SensorMerger::popReady(double now_s) {
  while (!measurements_.empty()) {
    const Pending& first = measurements_.front();
    const bool motion_known = newest_motion_s_ >= first.end_s;
    if (!motion_known && now_s - first.arrival_s <= config_.motion_wait_s) break;
    releaseFirstMeasurement();
  }
  if (motion_.size() > kMaxPendingMotion && measurements_.empty()) {
    releaseMotionUpTo(motion_[motion_.size() - kMaxPendingMotion].time_s);
  }
  return std::exchange(ready_, {});
}

std::vector<SensorEvent> SensorMerger::flush() {
  counts_.out_of_order += suspects_.size();
  suspects_.clear();
  releaseAll();
  return std::exchange(ready_, {});
}

void SensorMerger::reset() {
  motion_.clear();
  measurements_.clear();
  suspects_.clear();
  ready_.clear();
  forgetTimes();
}

void SensorMerger::releaseFirstMeasurement() {
  Pending first = std::move(measurements_.front());
  measurements_.pop_front();
  if (newest_motion_s_ < first.end_s) ++counts_.without_motion;
  releaseMotionUpTo(first.time_s);
  released_s_ = std::max(released_s_, first.time_s);
  auto* scan = std::get_if<ScanEvent>(&first.event);
  if (scan != nullptr && first.end_s > first.time_s) tellMotionMeanwhile(*scan);
  ready_.push_back(std::move(first.event));
}

void SensorMerger::tellMotionMeanwhile(ScanEvent& scan) const {
  const double end_s = scan.scan.time_s + scan.scan.sweep_s();
  for (const Pending& pending : motion_) {
    if (pending.time_s > end_s) break;
    const auto& input = std::get<MotionInput>(pending.event);
    if (isFinite(input)) scan.motion_meanwhile.push_back(input);
  }
}

void SensorMerger::releaseMotionUpTo(double time_s) {
  while (!motion_.empty() && motion_.front().time_s <= time_s) {
    released_s_ = std::max(released_s_, motion_.front().time_s);
    ready_.push_back(std::move(motion_.front().event));
    motion_.pop_front();
  }
}

void SensorMerger::releaseAll() {
  while (!measurements_.empty()) releaseFirstMeasurement();
  releaseMotionUpTo(std::numeric_limits<double>::infinity());
}

void SensorMerger::forgetTimes() {
  constexpr double kNever = -std::numeric_limits<double>::infinity();
  newest_motion_s_ = newest_s_ = released_s_ = kNever;
}

}  // namespace hymm::core
