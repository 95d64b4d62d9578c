#include "cekf/landmark_visibility.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {
namespace {

// A return nearer than the landmark's surface by more than this belongs to something before it.
constexpr double kOcclusionMargin_m = 0.5;

// A landmark is expected where it was seen before, not at the limit of its detection.
constexpr double kShareOfFarthestSighting = 0.8;

// Width beside a landmark, on either side, in which nothing nearer may stand.
constexpr double kClearance_m = 0.3;

bool hides(float range_m, double surface_m) {
  return std::isfinite(range_m) && range_m > 0.0F &&
         static_cast<double>(range_m) < surface_m - kOcclusionMargin_m;
}

/// Whether a beam tells anything of what stands in its way, be it that nothing does. A laser that
/// is masked, or a cloud that has no points there, tells nothing.
bool tells(float range_m, const LaserScan& scan) {
  return !std::isnan(range_m) && range_m > 0.0F && static_cast<double>(range_m) >= scan.range_min_m;
}

/// Bearing of a place from the first beam on, in the direction of the scan, within a turn.
double offsetOf(const Eigen::Vector2d& position, const LaserScan& scan) {
  const double sign = scan.angle_increment_rad > 0.0 ? 1.0 : -1.0;
  const double offset = sign * (std::atan2(position.y(), position.x()) - scan.angle_min_rad);
  return offset - 2.0 * kPi * std::floor(offset / (2.0 * kPi));
}

/// A place as seen from where the sensor was when its beam passed there. The beam depends on where
/// the sensor was, and that on the beam, but hardly.
Eigen::Vector2d fromPassingBeam(const Eigen::Vector2d& position, const LaserScan& scan) {
  if (scan.T_stamp_beam.empty()) return position;
  constexpr int kSteps = 2;
  const double step = std::abs(scan.angle_increment_rad);
  const double last = static_cast<double>(scan.T_stamp_beam.size() - 1);
  Eigen::Vector2d seen = position;
  for (int i = 0; i < kSteps; ++i) {
    const double beam = std::min(last, std::round(offsetOf(seen, scan) / step));
    seen = inverse(scan.T_stamp_beam[static_cast<std::size_t>(beam)]) * position;
  }
  return seen;
}

}  // namespace

bool shouldBeVisible(const LaserScan& scan, const Eigen::Vector2d& position_at_stamp,
                     const RegisteredLandmark& landmark, const LandmarkConfig& config) {
  const Eigen::Vector2d position = fromPassingBeam(position_at_stamp, scan);
  const double distance_m = position.norm();
  const double reach_m =
      std::min(config.visible_range_m, kShareOfFarthestSighting * landmark.farthest_seen_m);
  if (distance_m > reach_m || distance_m < std::max(1.0, scan.range_min_m)) return false;

  const double radius_m =
      std::isfinite(landmark.diameter_m) ? std::max(0.0, 0.5 * landmark.diameter_m) : 0.0;
  const double half_width = std::asin(std::min(1.0, (radius_m + kClearance_m) / distance_m));
  const double step = std::abs(scan.angle_increment_rad);
  const double offset = offsetOf(position, scan);
  const double span = step * static_cast<double>(scan.ranges_m.size() - 1);
  const double margin = std::max(half_width, config.field_margin_rad);
  if (offset < margin || offset > span - margin) return false;

  const auto first = static_cast<std::size_t>(std::floor((offset - half_width) / step));
  const auto last = static_cast<std::size_t>(std::ceil((offset + half_width) / step));
  const double surface_m = distance_m - radius_m;
  const auto begin = scan.ranges_m.begin() + static_cast<std::ptrdiff_t>(first);
  const auto end =
      scan.ranges_m.begin() + static_cast<std::ptrdiff_t>(std::min(last + 1, scan.ranges_m.size()));
  if (std::any_of(begin, end, [&](float range_m) { return hides(range_m, surface_m); })) {
    return false;
  }
  const auto telling =
      std::count_if(begin, end, [&](float range_m) { return tells(range_m, scan); });
  return 2 * telling >= end - begin;
}

}  // namespace hymm::core
