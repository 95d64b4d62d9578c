#include "ros/untimed_turns.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <sstream>
#include <variant>

#include "common/angles.h"

namespace hymm {
namespace {

constexpr std::size_t kMostFrames = 64;   // names come in messages
constexpr double kLongestPeriod_s = 1.0;  // between more distant stamps scans are missing

double speedOf(const core::MotionInput& input) {
  if (const auto* car = std::get_if<core::AckermannInput>(&input)) return std::abs(car->speed_mps);
  const auto& twist = std::get<core::TwistInput>(input);
  return std::hypot(twist.forward_mps, twist.lateral_mps);
}

}  // namespace

bool showsFullTurn(const core::LaserScan& scan) {
  constexpr double kParts = 8.0;
  std::bitset<static_cast<std::size_t>(kParts)> parts;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    if (std::isnan(scan.ranges_m[i])) continue;
    const double turn = (core::wrapAngle(scan.bearing(i)) + core::kPi) / (2.0 * core::kPi);
    parts.set(std::min(static_cast<std::size_t>(turn * kParts), parts.size() - 1));
  }
  return parts.all();
}

void UntimedTurns::take(const core::MotionInput& input) {
  if (core::isFinite(input)) speed_mps_ = speedOf(input);
}

void UntimedTurns::take(const core::LaserScan& scan, std::optional<double> period_s,
                        const std::string& frame, CauseLog& causes) {
  const double turn_s = period_s ? *period_s : periodByStamps(scan.time_s, frame);
  const double moved_m = speed_mps_ * turn_s;
  if (!(moved_m > kTold_m) || !showsFullTurn(scan)) return;
  if (moved_m > farthest_m_) {
    farthest_m_ = moved_m;
    farthest_frame_ = frame;
  }
  std::ostringstream sentence;
  sentence.precision(3);
  sentence << "Scans of frame '" << frame << "' do not tell when their beams were measured (time_"
           << "increment, or times of a cloud's points): if its laser turns once in the " << turn_s
           << " s between them, the vehicle moves " << moved_m
           << " m meanwhile at the present speed, and scans and map are bent by as much. Let the "
           << "driver tell it.";
  causes.count("scans of a full turn without the times of beams, the vehicle driving",
               sentence.str());
}

/// The lesser of the last two differences: a scan that got lost must not look like a slow laser.
double UntimedTurns::periodByStamps(double time_s, const std::string& frame) {
  if (clocks_.count(frame) == 0 && clocks_.size() >= kMostFrames) return 0.0;
  const auto [entry, is_first] = clocks_.try_emplace(frame, Clock{time_s, 0.0});
  if (is_first) return 0.0;
  Clock& clock = entry->second;
  const double now_s = time_s - clock.last_s;
  const double before_s = clock.difference_s;
  clock = {time_s, now_s};
  const double period_s = std::min(now_s, before_s);
  return period_s > 0.0 && period_s <= kLongestPeriod_s ? period_s : 0.0;
}

std::string UntimedTurns::summary() const {
  if (farthest_m_ == 0.0) return "";
  std::ostringstream sentence;
  sentence.precision(3);
  sentence << "the vehicle moved up to " << farthest_m_ << " m during a scan of frame '"
           << farthest_frame_
           << "' if its laser turns, which does not tell when its beams were measured";
  return sentence.str();
}

void UntimedTurns::reset() {
  clocks_.clear();
  speed_mps_ = 0.0;
}

}  // namespace hymm
