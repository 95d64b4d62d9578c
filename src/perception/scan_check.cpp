#include "perception/scan_check.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "common/angles.h"

namespace hymm::core {
namespace {

template <class... Parts>
std::string sentence(const Parts&... parts) {
  std::ostringstream stream;
  (stream << ... << parts);
  return stream.str();
}

std::optional<std::string> angleProblem(const LaserScan& scan) {
  if (!std::isfinite(scan.angle_min_rad)) {
    return sentence("angle_min is ", scan.angle_min_rad, " rad; it must be finite.");
  }
  if (!std::isfinite(scan.angle_increment_rad) || scan.angle_increment_rad == 0.0) {
    return sentence("angle_increment is ", scan.angle_increment_rad,
                    " rad; it must be finite and not zero.");
  }
  // Drivers of turning lasers repeat the first beam at the end, hence one beam more than a turn.
  const double turn_rad =
      std::abs(scan.angle_increment_rad) * static_cast<double>(scan.ranges_m.size());
  if (turn_rad > 2.0 * kPi + 1.5 * std::abs(scan.angle_increment_rad)) {
    return sentence(scan.ranges_m.size(), " ranges at an angle_increment of ",
                    scan.angle_increment_rad, " rad are more than one turn.");
  }
  return std::nullopt;
}

// Between a scan's end and the next one's begin a laser may pause, but they do not overlap; drivers
// that tell the times roughly are let pass.
constexpr double kRoughly = 1.5;

std::optional<std::string> limitProblem(const LaserScan& scan) {
  if (std::isfinite(scan.range_min_m) && scan.range_min_m >= 0.0 &&
      scan.range_max_m > scan.range_min_m) {
    return std::nullopt;
  }
  return sentence("range_min is ", scan.range_min_m, " m and range_max ", scan.range_max_m,
                  " m; they must be numbers with 0 <= range_min < range_max.");
}

std::optional<std::string> lengthProblem(const LaserScan& scan) {
  if (scan.ranges_m.empty()) return "ranges is empty.";
  if (!scan.intensities.empty() && scan.intensities.size() != scan.ranges_m.size()) {
    return sentence("intensities has ", scan.intensities.size(), " values and ranges ",
                    scan.ranges_m.size(), "; intensities must be as long as ranges, or empty.");
  }
  if (!scan.beam_times_s.empty() && scan.beam_times_s.size() != scan.ranges_m.size()) {
    return sentence("times are known for ", scan.beam_times_s.size(), " of ", scan.ranges_m.size(),
                    " beams; they must be for all, or for none.");
  }
  if (!scan.T_stamp_beam.empty() && scan.T_stamp_beam.size() != scan.ranges_m.size()) {
    return sentence("the sensor's motion is known for ", scan.T_stamp_beam.size(), " of ",
                    scan.ranges_m.size(), " beams; it must be for all, or for none.");
  }
  return std::nullopt;
}

std::optional<std::string> timeProblem(const LaserScan& scan) {
  if (!std::isfinite(scan.time_s)) {
    return sentence("the stamp is ", scan.time_s, " s; it must be finite.");
  }
  for (const float time_s : scan.beam_times_s) {
    if (time_s >= 0.0F && static_cast<double>(time_s) <= LaserScan::kLongestSweep_s) continue;
    return sentence("a beam was measured ", time_s, " s after the stamp; it must be 0 to ",
                    LaserScan::kLongestSweep_s, " s.");
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> scanProblem(const LaserScan& scan) {
  if (auto problem = timeProblem(scan)) return problem;
  if (auto problem = lengthProblem(scan)) return problem;
  if (auto problem = angleProblem(scan)) return problem;
  return limitProblem(scan);
}

std::optional<std::string> sweepProblem(const LaserScan& scan, double scan_time_s) {
  const double increment_s = scan.time_increment_s;
  if (!std::isfinite(increment_s) || increment_s < 0.0) {
    return sentence("time_increment is ", increment_s, " s; it must be finite and not negative.");
  }
  const double sweep_s = increment_s * static_cast<double>(scan.ranges_m.size());
  if (sweep_s > LaserScan::kLongestSweep_s) {
    return sentence(scan.ranges_m.size(), " ranges at a time_increment of ", increment_s,
                    " s take ", sweep_s, " s; more than ", LaserScan::kLongestSweep_s,
                    " s is not believed.");
  }
  if (scan_time_s > 0.0 && sweep_s > kRoughly * scan_time_s) {
    return sentence(scan.ranges_m.size(), " ranges at a time_increment of ", increment_s,
                    " s take ", sweep_s, " s, but scan_time says ", scan_time_s, " s.");
  }
  return std::nullopt;
}

std::size_t invalidRanges(const LaserScan& scan) {
  return static_cast<std::size_t>(
      std::count_if(scan.ranges_m.begin(), scan.ranges_m.end(),
                    [](float range) { return range < 0.0F && std::isfinite(range); }));
}

}  // namespace hymm::core
