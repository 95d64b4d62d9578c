#pragma once

#include <variant>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/pose2.h"

namespace hymm::core {

/// Plan views of solid things, in metres.
struct Disc {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius_m = 0.0;
};
struct Polygon {
  std::vector<Eigen::Vector2d> corners;  ///< closed: the last is joined to the first
};
using Shape = std::variant<Disc, Polygon>;

/// What a laser sees of a surface.
struct Material {
  double reflectivity = 0.3;      ///< of diffuse light, 0 to 1
  bool retro_reflective = false;  ///< sends light back where it came from
  double roughness_m = 0.0;       ///< deviation of the surface from its shape (leaves)
};

struct Solid {
  Shape shape;
  Material material;
  int landmark = -1;  ///< its id, if it is one
};

/// A rectangle of `length_m` along the pose's x axis, centred on the pose, whose corners are cut
/// by `chamfer_m`.
Polygon makeBox(const Pose2& centre, double length_m, double width_m, double chamfer_m = 0.0);

/// A wall between two points.
Polygon makeWall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double thickness_m);

/// The shape in the parent frame of `T_parent_child`.
Shape transformed(const Pose2& T_parent_child, const Shape& shape);

Eigen::AlignedBox2d boundsOf(const Shape& shape);

/// From a point to the shape; 0 inside.
double distanceBetween(const Eigen::Vector2d& point, const Shape& shape);

}  // namespace hymm::core
