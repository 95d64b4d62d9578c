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
  return std::nullopt;
}

}  // namespace

std::optional<std::string> scanProblem(const LaserScan& scan) {
  if (!std::isfinite(scan.time_s)) {
    return sentence("the stamp is ", scan.time_s, " s; it must be finite.");
  }
  if (auto problem = lengthProblem(scan)) return problem;
  if (auto problem = angleProblem(scan)) return problem;
  return limitProblem(scan);
}

std::size_t invalidRanges(const LaserScan& scan) {
  return static_cast<std::size_t>(
      std::count_if(scan.ranges_m.begin(), scan.ranges_m.end(),
                    [](float range) { return range < 0.0F && std::isfinite(range); }));
}

}  // namespace hymm::core
