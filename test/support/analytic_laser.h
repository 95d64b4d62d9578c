#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "common/angles.h"
#include "common/random.h"
#include "perception/laser_scan.h"

namespace hymm::core {

/// A planar world of discs and line segments in the sensor's frame, and an ideal laser in it:
/// ranges are exact, a beam has no width. For tests that need to know what is right.
class AnalyticLaser {
 public:
  AnalyticLaser& disc(double x_m, double y_m, double diameter_m) {
    discs_.push_back({{x_m, y_m}, 0.5 * diameter_m});
    return *this;
  }

  /// A disc whose centre is at a range and bearing.
  AnalyticLaser& trunk(double range_m, double bearing_rad, double diameter_m) {
    return disc(range_m * std::cos(bearing_rad), range_m * std::sin(bearing_rad), diameter_m);
  }

  AnalyticLaser& wall(double from_x_m, double from_y_m, double to_x_m, double to_y_m) {
    walls_.push_back({{from_x_m, from_y_m}, {to_x_m, to_y_m}});
    return *this;
  }

  double range(double bearing_rad) const {
    const Eigen::Vector2d direction(std::cos(bearing_rad), std::sin(bearing_rad));
    double nearest = std::numeric_limits<double>::infinity();
    for (const Disc& disc : discs_) nearest = std::min(nearest, rangeToDisc(disc, direction));
    for (const Wall& wall : walls_) nearest = std::min(nearest, rangeToWall(wall, direction));
    return nearest;
  }

  /// A scan of `beams` beams from `first_rad` on, `spacing_rad` apart (negative: clockwise).
  LaserScan scan(double first_rad, double spacing_rad, int beams) const {
    LaserScan scan;
    scan.angle_min_rad = first_rad;
    scan.angle_increment_rad = spacing_rad;
    scan.range_max_m = 80.0;
    for (int i = 0; i < beams; ++i) {
      const double r = range(scan.bearing(static_cast<std::size_t>(i)));
      scan.ranges_m.push_back(
          static_cast<float>(r < scan.range_max_m ? r : std::numeric_limits<double>::infinity()));
    }
    return scan;
  }

  /// 361 beams over the half plane ahead, half a degree apart.
  LaserScan halfTurn() const { return scan(-kPi / 2.0, kPi / 360.0, 361); }

 private:
  struct Disc {
    Eigen::Vector2d centre;
    double radius;
  };
  struct Wall {
    Eigen::Vector2d from, to;
  };

  static double rangeToDisc(const Disc& disc, const Eigen::Vector2d& direction) {
    const double along = disc.centre.dot(direction);
    const double across_squared = disc.centre.squaredNorm() - along * along;
    const double half_chord_squared = disc.radius * disc.radius - across_squared;
    if (half_chord_squared < 0.0 || along < 0.0) return std::numeric_limits<double>::infinity();
    return along - std::sqrt(half_chord_squared);
  }

  static double rangeToWall(const Wall& wall, const Eigen::Vector2d& direction) {
    const Eigen::Vector2d along = wall.to - wall.from;
    const double determinant = direction.x() * along.y() - direction.y() * along.x();
    if (determinant == 0.0) return std::numeric_limits<double>::infinity();
    const double range = (wall.from.x() * along.y() - wall.from.y() * along.x()) / determinant;
    const double share =
        (wall.from.x() * direction.y() - wall.from.y() * direction.x()) / determinant;
    const bool met = range > 0.0 && share >= 0.0 && share <= 1.0;
    return met ? range : std::numeric_limits<double>::infinity();
  }

  std::vector<Disc> discs_;
  std::vector<Wall> walls_;
};

/// Adds independent noise to all finite ranges and rounds them to `resolution_m` (0: not).
inline void addRangeNoise(LaserScan& scan, double deviation_m, double resolution_m,
                          RandomGenerator& generator) {
  for (float& range : scan.ranges_m) {
    if (!std::isfinite(range)) continue;
    double noisy = static_cast<double>(range) + sampleNormal(generator, deviation_m);
    if (resolution_m > 0.0) noisy = std::round(noisy / resolution_m) * resolution_m;
    range = static_cast<float>(noisy);
  }
}

}  // namespace hymm::core
