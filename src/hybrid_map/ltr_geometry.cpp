#include "hybrid_map/ltr_geometry.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace hymm::core {
namespace {

/// Whether a side of `a` has all of `b` on its outer side.
bool aSideSeparates(const Corners& a, const Corners& b) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector2d& from = a[i];
    const Eigen::Vector2d& to = a[i == 2 ? 0 : i + 1];
    if (turn(from, to, b[0]) <= 0.0 && turn(from, to, b[1]) <= 0.0 && turn(from, to, b[2]) <= 0.0) {
      return true;
    }
  }
  return false;
}

std::array<double, 3> sides(const Corners& corners) {
  return {(corners[1] - corners[0]).norm(), (corners[2] - corners[1]).norm(),
          (corners[0] - corners[2]).norm()};
}

}  // namespace

// Two convex sets have disjoint interiors if and only if a line separates them; for triangles one
// of the six sides then does. turn() is exactly 0 for a corner that both have.
bool overlap(const Corners& a, const Corners& b) {
  return !aSideSeparates(a, b) && !aSideSeparates(b, a);
}

double distanceToSegment(const Eigen::Vector2d& point, const Eigen::Vector2d& from,
                         const Eigen::Vector2d& to) {
  const Eigen::Vector2d side = to - from;
  const double squared = side.squaredNorm();
  const double along = squared > 0.0 ? (point - from).dot(side) / squared : 0.0;
  return (point - from - std::clamp(along, 0.0, 1.0) * side).norm();
}

double shortestSide(const Corners& corners) {
  const auto length = sides(corners);
  return *std::min_element(length.begin(), length.end());
}

double longestSide(const Corners& corners) {
  const auto length = sides(corners);
  return *std::max_element(length.begin(), length.end());
}

double smallestHeight(const Corners& corners) {
  const double longest = longestSide(corners);
  return longest > 0.0 ? std::abs(turn(corners[0], corners[1], corners[2])) / longest : 0.0;
}

double smallestAngle(const Corners& corners) {
  double smallest = M_PI;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector2d to_next = corners[(i + 1) % 3] - corners[i];
    const Eigen::Vector2d to_last = corners[(i + 2) % 3] - corners[i];
    const double cross = to_next.x() * to_last.y() - to_next.y() * to_last.x();
    smallest = std::min(smallest, std::abs(std::atan2(cross, to_next.dot(to_last))));
  }
  return smallest;
}

bool isInsideCircumcircle(const Corners& corners, const Eigen::Vector2d& point) {
  Eigen::Matrix3d lifted;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector2d d = corners[std::size_t(i)] - point;
    lifted.row(i) << d.x(), d.y(), d.squaredNorm();
  }
  return lifted.determinant() > 0.0;
}

// Principal stretches s satisfy p(s^2) = 0 for p(x) = x^2 - tr(C) x + det(C), C = F'F. Both lie in
// [1/limit, limit] if and only if p is not negative at both ends and its vertex lies in between.
bool keepsShape(const Eigen::Matrix2d& deformation, double limit) {
  const double determinant = deformation.determinant();
  const double trace = deformation.squaredNorm();
  const double high = limit * limit, low = 1.0 / high;
  const auto p = [&](double x) { return x * x - trace * x + determinant * determinant; };
  return determinant > 0.0 && 0.5 * trace >= low && 0.5 * trace <= high && p(low) >= 0.0 &&
         p(high) >= 0.0;
}

Pose2 bestRigidFit(const Corners& from, const Corners& to, const std::array<double, 3>& weights) {
  Eigen::Vector2d from_centre = Eigen::Vector2d::Zero(), to_centre = Eigen::Vector2d::Zero();
  double weight = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    from_centre += weights[i] * from[i];
    to_centre += weights[i] * to[i];
    weight += weights[i];
  }
  if (weight <= 0.0) return {};
  from_centre /= weight;
  to_centre /= weight;
  double sine = 0.0, cosine = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector2d f = from[i] - from_centre, t = to[i] - to_centre;
    sine += weights[i] * (f.x() * t.y() - f.y() * t.x());
    cosine += weights[i] * f.dot(t);
  }
  Pose2 turned{0.0, 0.0, std::atan2(sine, cosine)};
  const Eigen::Vector2d shift = to_centre - turned * from_centre;
  return {shift.x(), shift.y(), turned.yaw_rad};
}

double shapeFactor(const Corners& corners, const Eigen::Matrix<double, 6, 6>& covariance) {
  Eigen::Matrix2d M;  // (2): columns a, b
  M << corners[1] - corners[0], corners[2] - corners[0];
  const Eigen::Matrix2d N = M.inverse();
  // Gradients of the local weights: dM inv(M) = sum over the vertices of dL_k g_k'.
  const std::array<Eigen::RowVector2d, 3> g = {-(N.row(0) + N.row(1)), N.row(0), N.row(1)};
  Eigen::Matrix<double, 3, 6> J;  // of (E_xx, E_yy, E_xy) by the corners
  for (int k = 0; k < 3; ++k) {
    const Eigen::RowVector2d& gradient = g[std::size_t(k)];
    J.block<3, 2>(0, 2 * k) << gradient.x(), 0.0, 0.0, gradient.y(), 0.5 * gradient.y(),
        0.5 * gradient.x();
  }
  const Eigen::Matrix3d strain = J * covariance * J.transpose();
  // The variance of u' E u is a trigonometric polynomial of degree 2 in twice u's angle: its
  // largest value on 32 even steps, over cos(2 pi / 32), bounds it everywhere.
  constexpr int kSteps = 32;
  double variance = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double angle = M_PI * i / kSteps;
    const double c = std::cos(angle), s = std::sin(angle);
    const Eigen::Vector3d u(c * c, s * s, 2.0 * c * s);
    variance = std::max(variance, u.dot(strain * u));
  }
  return 1.0 + 3.0 * std::sqrt(variance / std::cos(2.0 * M_PI / kSteps));
}

}  // namespace hymm::core
