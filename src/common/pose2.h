#pragma once

#include <Eigen/Core>

#include "common/angles.h"

namespace hymm::core {

/// A planar rigid transform: `T_map_base * p_base` is `p_map`. Position in metres, yaw in radians,
/// counter-clockwise from the parent's x axis and kept within [-pi, pi].
struct Pose2 {
  double x_m = 0.0;
  double y_m = 0.0;
  double yaw_rad = 0.0;

  Eigen::Vector2d position() const { return {x_m, y_m}; }
  Eigen::Vector3d vector() const { return {x_m, y_m, yaw_rad}; }
  static Pose2 fromVector(const Eigen::Vector3d& v) { return {v.x(), v.y(), wrapAngle(v.z())}; }

  /// Rotation matrix of the yaw.
  Eigen::Matrix2d rotation() const {
    const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
    return (Eigen::Matrix2d() << c, -s, s, c).finished();
  }
};

/// Composition: T_a_c = T_a_b * T_b_c.
inline Pose2 operator*(const Pose2& a, const Pose2& b) {
  const Eigen::Vector2d p = a.position() + a.rotation() * b.position();
  return {p.x(), p.y(), wrapAngle(a.yaw_rad + b.yaw_rad)};
}

/// Point in the child frame to the parent frame.
inline Eigen::Vector2d operator*(const Pose2& a, const Eigen::Vector2d& p) {
  return a.position() + a.rotation() * p;
}

inline Pose2 inverse(const Pose2& a) {
  const Eigen::Vector2d p = -(a.rotation().transpose() * a.position());
  return {p.x(), p.y(), wrapAngle(-a.yaw_rad)};
}

}  // namespace hymm::core
