#include "ros/stamp_comparison.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace hymm {
namespace {

constexpr std::size_t kMostKept = 1U << 16U;
// What is stamped with the begin of a turn of the sensor and has gone through a driver comes
// later than encoders, but not by so much.
constexpr double kApart_s = 0.2;
constexpr double kStray = 0.01;        // share of messages at either end that may be
constexpr double kFewestShared = 0.5;  // of the scans' time
constexpr double kPeriod_s = 1.0;      // the first or last message of motion may be missing

double quantile(std::vector<double> values, double share) {
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(
                                          share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

}  // namespace

void StampComparison::add(Source source, double stamp_s, double recorded_s) {
  if (stamp_s == 0.0) return;
  Sample& sample = source == Source::kMotion ? motion_ : scans_;
  if (sample.seen++ % sample.stride != 0) return;
  sample.kept.push_back({stamp_s, recorded_s});
  if (sample.kept.size() < kMostKept) return;
  for (std::size_t i = 0; i < kMostKept / 2; ++i) sample.kept[i] = sample.kept[2 * i];
  sample.kept.resize(kMostKept / 2);
  sample.stride *= 2;
}

/// Of the stamps before the time of recording.
double StampComparison::medianAhead(const Sample& sample) {
  std::vector<double> ahead;
  for (const Stamped& one : sample.kept) ahead.push_back(one.stamp_s - one.recorded_s);
  return quantile(std::move(ahead), 0.5);
}

StampComparison::Span StampComparison::span(const Sample& sample) {
  std::vector<double> stamps;
  for (const Stamped& one : sample.kept) stamps.push_back(one.stamp_s);
  return {quantile(stamps, kStray), quantile(stamps, 1.0 - kStray)};
}

std::vector<std::string> StampComparison::problems() const {
  std::vector<std::string> problems;
  if (motion_.kept.empty() || scans_.kept.empty()) return problems;
  std::ostringstream text;
  text.precision(3);
  text << std::fixed;
  const double apart_s = medianAhead(motion_) - medianAhead(scans_);
  if (std::abs(apart_s) > kApart_s) {
    text
        << "The stamps of motion are " << std::abs(apart_s) << " s "
        << (apart_s > 0.0 ? "ahead of" : "behind")
        << " those of scans, measured by when both were recorded (medians): their clocks disagree, "
           "or one of them comes so late. Wrong stamps make a wrong map; synchronise the clocks.";
    problems.push_back(text.str());
    text.str("");
  }
  const Span motion = span(motion_), scans = span(scans_);
  const double length_s = scans.end_s - scans.begin_s;
  const double shared_s =
      std::min(scans.end_s, motion.end_s) - std::max(scans.begin_s, motion.begin_s);
  if (shared_s < kFewestShared * length_s || areApart()) {
    text << "Motion is stamped from " << motion.begin_s << " s to " << motion.end_s
         << " s, scans from " << scans.begin_s << " s to " << scans.end_s
         << " s: for most of the scans' time nothing tells how the vehicle moves.";
    problems.push_back(text.str());
  }
  return problems;
}

bool StampComparison::areApart() const {
  if (motion_.kept.empty() || scans_.kept.empty()) return false;
  const Span motion = span(motion_), scans = span(scans_);
  return motion.end_s < scans.begin_s - kPeriod_s || motion.begin_s > scans.end_s + kPeriod_s;
}

}  // namespace hymm
