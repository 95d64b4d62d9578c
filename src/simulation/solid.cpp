#include "simulation/solid.h"

#include <algorithm>
#include <limits>

namespace hymm::core {
namespace {

double distanceToEdge(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                      const Eigen::Vector2d& b) {
  const Eigen::Vector2d edge = b - a;
  const double along = std::clamp((p - a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
  return (p - a - along * edge).norm();
}

/// Whether the horizontal ray from p towards greater x crosses the edge.
bool crossesEdge(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  if ((a.y() > p.y()) == (b.y() > p.y())) return false;
  return p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
}

double distanceToPolygon(const Eigen::Vector2d& p, const Polygon& polygon) {
  double distance = std::numeric_limits<double>::infinity();
  bool inside = false;
  const std::size_t n = polygon.corners.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d& a = polygon.corners[i];
    const Eigen::Vector2d& b = polygon.corners[(i + 1) % n];
    distance = std::min(distance, distanceToEdge(p, a, b));
    if (crossesEdge(p, a, b)) inside = !inside;
  }
  return inside ? 0.0 : distance;
}

}  // namespace

Polygon makeBox(const Pose2& centre, double length_m, double width_m, double chamfer_m) {
  const double l = length_m / 2.0, w = width_m / 2.0, c = chamfer_m;
  std::vector<Eigen::Vector2d> corners;
  if (c > 0.0) {
    corners = {{l, -w + c}, {l, w - c},   {l - c, w},   {-l + c, w},
               {-l, w - c}, {-l, -w + c}, {-l + c, -w}, {l - c, -w}};
  } else {
    corners = {{l, -w}, {l, w}, {-l, w}, {-l, -w}};
  }
  for (Eigen::Vector2d& corner : corners) corner = centre * corner;
  return {corners};
}

Polygon makeWall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double thickness_m) {
  const Eigen::Vector2d along = to - from, middle = 0.5 * (from + to);
  return makeBox({middle.x(), middle.y(), std::atan2(along.y(), along.x())}, along.norm(),
                 thickness_m);
}

Shape transformed(const Pose2& T_parent_child, const Shape& shape) {
  if (const auto* disc = std::get_if<Disc>(&shape)) {
    return Disc{T_parent_child * disc->centre, disc->radius_m};
  }
  Polygon polygon = std::get<Polygon>(shape);
  for (Eigen::Vector2d& corner : polygon.corners) corner = T_parent_child * corner;
  return polygon;
}

Eigen::AlignedBox2d boundsOf(const Shape& shape) {
  if (const auto* disc = std::get_if<Disc>(&shape)) {
    const Eigen::Vector2d radius = Eigen::Vector2d::Constant(disc->radius_m);
    return {disc->centre - radius, disc->centre + radius};
  }
  Eigen::AlignedBox2d bounds;
  for (const Eigen::Vector2d& corner : std::get<Polygon>(shape).corners) bounds.extend(corner);
  return bounds;
}

double distanceBetween(const Eigen::Vector2d& point, const Shape& shape) {
  if (const auto* disc = std::get_if<Disc>(&shape)) {
    return std::max(0.0, (point - disc->centre).norm() - disc->radius_m);
  }
  return distanceToPolygon(point, std::get<Polygon>(shape));
}

}  // namespace hymm::core
