#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/pose2.h"

namespace hymm::core {

/// A closed path, by the length driven along it; it repeats after length_m().
class Route {
 public:
  Route() = default;

  /// Through `points`, closed; sampled anew at even steps. At least two points that differ.
  explicit Route(const std::vector<Eigen::Vector2d>& points);

  /// The polygon of `corners` with its corners rounded to about `radius_m`, and the curvature
  /// eased in and out so that a car can follow.
  static Route rounded(const std::vector<Eigen::Vector2d>& corners, double radius_m);

  double length_m() const { return step_m_ * static_cast<double>(points_.size()); }
  /// Position and direction after `along_m`.
  Pose2 at(double along_m) const;
  /// Left positive.
  double curvature(double along_m) const;
  double greatestCurvature() const;
  /// Where the route comes nearest to `point`, between `from_m` and `to_m`.
  double nearest(const Eigen::Vector2d& point, double from_m, double to_m) const;

  Route transformed(const Pose2& T_parent_child) const;
  /// Evenly spaced along the route.
  const std::vector<Eigen::Vector2d>& points() const { return points_; }

 private:
  Eigen::Vector2d position(double along_m) const;

  std::vector<Eigen::Vector2d> points_;
  double step_m_ = 0.0;
};

}  // namespace hymm::core
