#include "simulation/route.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hymm::core {
namespace {

constexpr double kStep_m = 0.25;
// Directions and curvatures are taken over this length, so that sampling does not show in them.
constexpr double kBase_m = 0.5;
// Curvature of a rounded corner is eased in over this length.
constexpr double kEasing_m = 3.0;

/// Points at even steps along the closed polygon of `points`, and the step.
std::vector<Eigen::Vector2d> resampled(const std::vector<Eigen::Vector2d>& points, double& step_m) {
  const std::size_t n = points.size();
  std::vector<double> along{0.0};
  for (std::size_t i = 0; i < n; ++i) {
    along.push_back(along.back() + (points[(i + 1) % n] - points[i]).norm());
  }
  const double length = along.back();
  const auto count = std::max<std::size_t>(8, static_cast<std::size_t>(length / kStep_m));
  step_m = length / static_cast<double>(count);
  std::vector<Eigen::Vector2d> samples;
  samples.reserve(count);
  std::size_t i = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const double s = step_m * static_cast<double>(k);
    while (i + 1 < n && along[i + 1] <= s) ++i;
    const double share = (s - along[i]) / (along[i + 1] - along[i]);
    samples.push_back(points[i] + share * (points[(i + 1) % n] - points[i]));
  }
  return samples;
}

/// Appends the arc that rounds the corner between its neighbours.
void appendArc(const Eigen::Vector2d& before, const Eigen::Vector2d& corner,
               const Eigen::Vector2d& after, double radius_m,
               std::vector<Eigen::Vector2d>& points) {
  const Eigen::Vector2d in = (corner - before).normalized(), out = (after - corner).normalized();
  const double turn = std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out));
  if (std::abs(turn) < 1e-6) {
    points.push_back(corner);
    return;
  }
  const double tangent = std::min({radius_m * std::tan(std::abs(turn) / 2.0),
                                   0.5 * (corner - before).norm(), 0.5 * (after - corner).norm()});
  const double radius = tangent / std::tan(std::abs(turn) / 2.0);
  const Eigen::Vector2d start = corner - tangent * in;
  const Eigen::Vector2d left(-in.y(), in.x());
  const Eigen::Vector2d centre = start + std::copysign(radius, turn) * left;
  constexpr int kPieces = 24;
  for (int k = 0; k <= kPieces; ++k) {
    const Pose2 rotation{0.0, 0.0, turn * k / kPieces};
    points.push_back(centre + rotation.rotation() * (start - centre));
  }
}

/// Each point replaced by the mean of its neighbourhood of `window_m` along the closed path.
std::vector<Eigen::Vector2d> smoothed(const std::vector<Eigen::Vector2d>& points, double step_m,
                                      double window_m) {
  const std::size_t n = points.size();
  const auto half = std::min(n / 4, static_cast<std::size_t>(window_m / step_m / 2.0));
  std::vector<Eigen::Vector2d> means(n);
  for (std::size_t i = 0; i < n; ++i) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (std::size_t k = 0; k <= 2 * half; ++k) sum += points[(i + n - half + k) % n];
    means[i] = sum / static_cast<double>(2 * half + 1);
  }
  return means;
}

}  // namespace

Route::Route(const std::vector<Eigen::Vector2d>& points) { points_ = resampled(points, step_m_); }

Route Route::rounded(const std::vector<Eigen::Vector2d>& corners, double radius_m) {
  std::vector<Eigen::Vector2d> points;
  const std::size_t n = corners.size();
  for (std::size_t i = 0; i < n; ++i) {
    appendArc(corners[(i + n - 1) % n], corners[i], corners[(i + 1) % n], radius_m, points);
  }
  const Route sharp(points);
  return Route(smoothed(sharp.points_, sharp.step_m_, kEasing_m));
}

Eigen::Vector2d Route::position(double along_m) const {
  const double steps = along_m / step_m_;
  const double floor = std::floor(steps);
  const auto n = static_cast<std::int64_t>(points_.size());
  const auto i = ((static_cast<std::int64_t>(floor) % n) + n) % n;
  const auto& a = points_[static_cast<std::size_t>(i)];
  const auto& b = points_[static_cast<std::size_t>((i + 1) % n)];
  return a + (steps - floor) * (b - a);
}

Pose2 Route::at(double along_m) const {
  const Eigen::Vector2d p = position(along_m);
  const Eigen::Vector2d chord = position(along_m + kBase_m) - position(along_m - kBase_m);
  return {p.x(), p.y(), std::atan2(chord.y(), chord.x())};
}

double Route::curvature(double along_m) const {
  return wrapAngle(at(along_m + kBase_m).yaw_rad - at(along_m - kBase_m).yaw_rad) / (2.0 * kBase_m);
}

double Route::greatestCurvature() const {
  double greatest = 0.0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    greatest = std::max(greatest, std::abs(curvature(step_m_ * static_cast<double>(i))));
  }
  return greatest;
}

double Route::nearest(const Eigen::Vector2d& point, double from_m, double to_m) const {
  double best = from_m, best_squared = std::numeric_limits<double>::infinity();
  const auto steps = static_cast<int>((to_m - from_m) / kStep_m * 4.0) + 1;
  for (int k = 0; k <= steps; ++k) {
    const double s = from_m + (to_m - from_m) * k / steps;
    const double squared = (position(s) - point).squaredNorm();
    if (squared < best_squared) {
      best_squared = squared;
      best = s;
    }
  }
  return best;
}

Route Route::transformed(const Pose2& T_parent_child) const {
  Route moved = *this;
  for (Eigen::Vector2d& point : moved.points_) point = T_parent_child * point;
  return moved;
}

}  // namespace hymm::core
