#include "perception/point_scan.h"

#include <cmath>
#include <limits>

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

LaserScan scanOfPoints(const std::vector<Eigen::Vector3f>& points, double time_s,
                       const PointCloudConfig& config) {
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
  for (const Eigen::Vector3f& point : points) {
    if (!point.allFinite()) continue;
    const float range_m = point.head<2>().norm();
    if (static_cast<double>(range_m) < config.min_range_m) continue;
    const double turn = static_cast<double>(std::atan2(point.y(), point.x())) + kPi;
    const auto direction = static_cast<std::size_t>(std::lround(turn / scan.angle_increment_rad));
    float& nearest_m = scan.ranges_m[direction % scan.ranges_m.size()];
    const bool is_obstacle = isInBand(static_cast<double>(range_m), static_cast<double>(point.z()));
    // The order also replaces NaN by anything.
    nearest_m = std::fmin(nearest_m, is_obstacle ? range_m : kNoReturn);
  }
  return scan;
}

}  // namespace hymm::core
