#include "perception/point_scan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/angles.h"

namespace hymm::core {

void PointCloudConfig::describe(ConfigSchema& schema) {
  schema.number("min_height_m", min_height_m, Range::any(),
                "above base_link, from which points of a cloud are obstacles");
  schema.number("band_height_m", band_height_m, Range::positive(),
                "above that, up to which they are");
  schema.number("min_range_m", min_range_m, Range::notNegative(),
                "from the sensor; nearer points belong to the vehicle");
  schema.number("max_range_m", max_range_m, Range::positive(),
                "up to which obstacles are believed");
  schema.integer("directions", directions, Range::between(8.0, 7200.0),
                 "all around, in each of which the nearest obstacle counts");
}

namespace {

/// The direction behind the greatest step in time between neighbours that were measured: there a
/// turn ends and begins. What stands across it is not one shape.
std::size_t beginOfTurn(const std::vector<float>& times_s) {
  std::size_t begin = 0, before = times_s.size();
  float greatest_s = 0.0F;
  // Once around, and on to the first that was measured.
  for (std::size_t i = 0; i < 2 * times_s.size(); ++i) {
    const std::size_t direction = i % times_s.size();
    if (std::isnan(times_s[direction])) continue;
    if (before == times_s.size()) {
      begin = direction;
    } else {
      const float step_s = std::abs(times_s[direction] - times_s[before]);
      if (step_s > greatest_s) greatest_s = step_s, begin = direction;
    }
    before = direction;
  }
  return begin;
}

/// Gives a scan the times of those directions that were measured (NaN: not), and begins it where
/// the turn does.
void tellTimes(std::vector<float> times_s, LaserScan& scan) {
  const std::size_t begin = beginOfTurn(times_s);
  if (std::isnan(times_s[begin])) return;
  const auto turned = static_cast<std::ptrdiff_t>(begin);
  std::rotate(times_s.begin(), times_s.begin() + turned, times_s.end());
  for (std::size_t i = 1; i < times_s.size(); ++i) {
    if (std::isnan(times_s[i])) times_s[i] = times_s[i - 1];
  }
  std::rotate(scan.ranges_m.begin(), scan.ranges_m.begin() + turned, scan.ranges_m.end());
  scan.angle_min_rad += static_cast<double>(begin) * scan.angle_increment_rad;
  scan.beam_times_s = std::move(times_s);
}

}  // namespace

bool isSeen(const Eigen::Vector3f& point, const PointCloudConfig& config) {
  return point.allFinite() && static_cast<double>(point.head<2>().norm()) >= config.min_range_m;
}

LaserScan scanOfPoints(const std::vector<Eigen::Vector3f>& points, double time_s,
                       const PointCloudConfig& config, const std::vector<float>& times_s) {
  constexpr float kNoReturn = std::numeric_limits<float>::infinity();
  LaserScan scan;
  scan.time_s = time_s;
  scan.angle_increment_rad = 2.0 * kPi / config.directions;
  // Straight ahead is the middle of a direction, as it is for most sensors: their points must not
  // fall on borders, where rounding would put two into one direction and none into the next.
  scan.angle_min_rad = -kPi;
  scan.range_min_m = config.min_range_m;
  scan.range_max_m = config.max_range_m;
  scan.ranges_m.assign(static_cast<std::size_t>(config.directions),
                       std::numeric_limits<float>::quiet_NaN());
  const auto isInBand = [&](double range_m, double height_m) {
    return range_m <= config.max_range_m && height_m >= config.min_height_m &&
           height_m <= config.min_height_m + config.band_height_m;
  };
  std::vector<float> seen_s(times_s.empty() ? 0 : scan.ranges_m.size(),
                            std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f& point = points[i];
    if (!isSeen(point, config)) continue;
    const float range_m = point.head<2>().norm();
    const double turn = static_cast<double>(std::atan2(point.y(), point.x())) + kPi;
    const std::size_t direction =
        static_cast<std::size_t>(std::lround(turn / scan.angle_increment_rad)) %
        scan.ranges_m.size();
    float& nearest_m = scan.ranges_m[direction];
    const bool is_obstacle = isInBand(static_cast<double>(range_m), static_cast<double>(point.z()));
    const float shown_m = is_obstacle ? range_m : kNoReturn;
    if (nearest_m <= shown_m) continue;  // not if it is NaN
    nearest_m = shown_m;
    if (!times_s.empty()) seen_s[direction] = times_s[i];
  }
  if (!times_s.empty()) tellTimes(std::move(seen_s), scan);
  return scan;
}

}  // namespace hymm::core
