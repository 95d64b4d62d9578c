#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "common/angles.h"
#include "common/pose2.h"
#include "common/random.h"
#include "perception/laser_scan.h"

namespace hymm::core {

/// A planar world of ellipses and line segments in the sensor's frame, and an ideal laser in it:
/// ranges are exact, a beam has no width. For tests that need to know what is right.
class AnalyticLaser {
 public:
  AnalyticLaser& disc(double x_m, double y_m, double diameter_m) {
    return ellipse({x_m, y_m}, diameter_m, diameter_m, 0.0);
  }

  /// An ellipse whose first axis has the direction `turn_rad`.
  AnalyticLaser& ellipse(const Eigen::Vector2d& centre, double first_axis_m, double second_axis_m,
                         double turn_rad) {
    const Pose2 T_sensor_ellipse{centre.x(), centre.y(), turn_rad};
    ellipses_.push_back({inverse(T_sensor_ellipse), {2.0 / first_axis_m, 2.0 / second_axis_m}});
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
    for (const Ellipse& ellipse : ellipses_) {
      nearest = std::min(nearest, rangeToEllipse(ellipse, direction));
    }
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
  struct Ellipse {
    Pose2 T_ellipse_sensor;
    Eigen::Vector2d scale;  ///< makes it the unit circle
  };
  struct Wall {
    Eigen::Vector2d from, to;
  };

  static double rangeToEllipse(const Ellipse& ellipse, const Eigen::Vector2d& direction) {
    const Eigen::Vector2d from = ellipse.scale.cwiseProduct(ellipse.T_ellipse_sensor.position());
    const Eigen::Vector2d along =
        ellipse.scale.cwiseProduct(ellipse.T_ellipse_sensor.rotation() * direction);
    const double a = along.squaredNorm(), b = from.dot(along);
    const double discriminant = b * b - a * (from.squaredNorm() - 1.0);
    if (discriminant < 0.0 || b > 0.0) return std::numeric_limits<double>::infinity();
    return (-b - std::sqrt(discriminant)) / a;
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

  std::vector<Ellipse> ellipses_;
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
