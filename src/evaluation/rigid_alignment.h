#pragma once

#include <cstddef>

#include "common/pose2.h"

namespace hymm::core {

/// The rotation and translation (no scale) that bring points of one plane nearest to their
/// partners in another, in the least-squares sense: Umeyama, "Least-squares estimation of
/// transformation parameters between two point patterns", PAMI 13(4), 1991, for two dimensions.
/// Keeps sums only, whatever the number of points.
class RigidAlignment {
 public:
  /// `p_from` and `p_to` are the same point [m] in the two frames.
  void add(const Eigen::Vector2d& p_from, const Eigen::Vector2d& p_to);

  std::size_t count() const { return count_; }

  /// The transform of points in `from` to points in `to`; identity without points, a pure
  /// translation where all points coincide.
  Pose2 T_to_from() const;

  /// Sum over the points of the squared distance [m^2] that remains after T_to_from().
  double squaredError() const;

 private:
  std::size_t count_ = 0;
  Eigen::Vector2d mean_from_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d mean_to_ = Eigen::Vector2d::Zero();
  double dot_ = 0.0;     ///< sum of from . to about the means
  double cross_ = 0.0;   ///< sum of from x to about the means
  double spread_ = 0.0;  ///< sum of |from|^2 + |to|^2 about the means
};

}  // namespace hymm::core
