#pragma once

#include <array>

#include <Eigen/Core>

#include "common/pose2.h"

namespace hymm::core {

/// Corners of a triangle in map [m].
using Corners = std::array<Eigen::Vector2d, 3>;

/// Twice the signed area of (a, b, c) [m^2]: positive where they turn to the left.
inline double turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// Whether the interiors of two triangles with counter-clockwise corners have a point in common.
/// Triangles that share corners or a side exactly (the same numbers) do not for that reason.
bool overlap(const Corners& a, const Corners& b);

/// Distance [m] of a point from the straight line between two others.
double distanceToSegment(const Eigen::Vector2d& point, const Eigen::Vector2d& from,
                         const Eigen::Vector2d& to);

double shortestSide(const Corners& corners);
double longestSide(const Corners& corners);
double smallestAngle(const Corners& corners);
/// Distance [m] of the longest side from the corner that is not on it.
double smallestHeight(const Corners& corners);

/// Whether a point lies inside the circle through counter-clockwise corners.
bool isInsideCircumcircle(const Corners& corners, const Eigen::Vector2d& point);

/// Whether the linear map `deformation` keeps orientation and changes no length by more than the
/// factor `limit` (> 1), up or down.
bool keepsShape(const Eigen::Matrix2d& deformation, double limit);

/// The turn and shift that bring `from` nearest to `to`, least squares over the corners with
/// `weights` > 0. With one such corner: the shift; with none: nothing moves.
Pose2 bestRigidFit(const Corners& from, const Corners& to, const std::array<double, 3>& weights);

/// Shape factor K = 1 + 3 max_u sigma(u' E u), E = sym(dM inv(M)): at 3 sigma no length inside the
/// triangle is longer than K times what it seems. `covariance` is that of the corners together
/// [m^2]; what they have in common (shift and turn) makes no part of it. The paper's (16), (17)
/// look at the sides only, which do not bound the other directions.
double shapeFactor(const Corners& corners, const Eigen::Matrix<double, 6, 6>& covariance);

}  // namespace hymm::core
