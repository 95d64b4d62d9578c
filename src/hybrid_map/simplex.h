#pragma once

#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

namespace hymm::core {

/// Points are taken to lie on the border of a region up to this barycentric coordinate, so that
/// rounding leaves no gap between two regions that share a side.
constexpr double kBorderTolerance = 1e-9;

/// The region that `Vertices` landmarks span in a space of `Dimension` dimensions, with its local
/// coordinates (alpha, beta[, gamma]) of equations (2)-(8):
///   Simplex<2, 3>  triangle in the plane (an LTR),
///   Simplex<3, 3>  triangle with vertices in space (Figure 7: a piece of terrain),
///   Simplex<3, 4>  tetrahedron (7), (8).
/// Coordinates are affine: they stay with what they describe when the vertices move. A simplex
/// without extent (collinear vertices) has local coordinates that are not finite and contains
/// nothing.
template <int Dimension, int Vertices>
class Simplex {
  static_assert(Vertices >= 3 && Vertices <= Dimension + 1);

 public:
  static constexpr int kLocal = Vertices - 1;
  using Point = Eigen::Matrix<double, Dimension, 1>;              ///< m
  using Local = Eigen::Matrix<double, kLocal, 1>;                 ///< (alpha, beta[, gamma])
  using Weights = Eigen::Matrix<double, Vertices, 1>;             ///< of the vertices, sum 1
  using Edges = Eigen::Matrix<double, Dimension, kLocal>;         ///< columns a, b[, c], m
  using EdgesInverse = Eigen::Matrix<double, kLocal, Dimension>;  ///< 1/m

  /// Without extent, at the origin.
  Simplex() = default;

  /// (2), (7): the frame stands at the first vertex, its axes are the edges to the others.
  explicit Simplex(const std::array<Point, Vertices>& vertices) : origin_(vertices[0]) {
    for (int i = 0; i < kLocal; ++i) edges_.col(i) = vertices[std::size_t(i) + 1] - vertices[0];
    if constexpr (kLocal == Dimension) {
      inverse_ = edges_.inverse();
    } else {
      // Of all points of a triangle in space, the nearest: the foot of the perpendicular.
      inverse_ = (edges_.transpose() * edges_).inverse() * edges_.transpose();
    }
  }

  template <class Archive>
  void describeState(Archive& archive) {
    archive(origin_, edges_, inverse_);
  }

  const Point& origin() const { return origin_; }
  const Edges& edges() const { return edges_; }
  const EdgesInverse& edgesInverse() const { return inverse_; }

  Point vertex(int index) const {
    return index == 0 ? origin_ : Point(origin_ + edges_.col(index - 1));
  }

  /// (3), (8).
  Point toGlobal(const Local& local) const { return origin_ + edges_ * local; }

  /// Inverse of (3), (8). A point off the plane of a triangle in space has the coordinates of its
  /// foot on the plane; see height().
  Local toLocal(const Point& point) const { return inverse_ * (point - origin_); }

  /// (3): the convex combination that a point is, (1 - alpha - beta, alpha, beta).
  static Weights weights(const Local& local) {
    Weights weights;
    weights[0] = 1.0 - local.sum();
    weights.template tail<kLocal>() = local;
    return weights;
  }

  /// (3), (8), the borders included.
  static bool containsLocal(const Local& local) {
    return weights(local).minCoeff() >= -kBorderTolerance;
  }
  bool contains(const Point& point) const {
    const Local local = toLocal(point);
    return local.allFinite() && containsLocal(local);
  }

  /// (6): how far a point moves when the vertices move by `shifts`.
  static Point displacement(const Local& local, const std::array<Point, Vertices>& shifts) {
    const Weights w = weights(local);
    Point moved = w[0] * shifts[0];
    for (int i = 1; i < Vertices; ++i) moved += w[i] * shifts[std::size_t(i)];
    return moved;
  }

  /// Area [m^2] or volume [m^3]. In the full space it is signed: positive for vertices in
  /// counter-clockwise order, or a right-handed (a, b, c).
  double measure() const {
    constexpr double kFactorial = kLocal == 2 ? 2.0 : 6.0;
    if constexpr (kLocal == Dimension) {
      return edges_.determinant() / kFactorial;
    } else {
      return std::sqrt((edges_.transpose() * edges_).determinant()) / kFactorial;
    }
  }

  /// Distance [m] of a point from the plane of a triangle in space, positive on the side from
  /// which its vertices run counter-clockwise: "the level of the terrain surface in respect to the
  /// triangular flat LTR" (III.A).
  double height(const Point& point) const {
    static_assert(Dimension == 3 && kLocal == 2, "only a triangle in space has a height above it");
    const Point normal = edges_.col(0).cross(edges_.col(1)).normalized();
    return normal.dot(point - origin_);
  }

 private:
  Point origin_ = Point::Zero();
  Edges edges_ = Edges::Zero();
  EdgesInverse inverse_ = EdgesInverse::Constant(std::numeric_limits<double>::quiet_NaN());
};

using Triangle = Simplex<2, 3>;
using TerrainTriangle = Simplex<3, 3>;
using Tetrahedron = Simplex<3, 4>;

}  // namespace hymm::core
