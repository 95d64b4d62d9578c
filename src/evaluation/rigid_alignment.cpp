#include "evaluation/rigid_alignment.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {

void RigidAlignment::add(const Eigen::Vector2d& p_from, const Eigen::Vector2d& p_to) {
  // Welford's update: sums about the running means lose no digits far from the origin.
  const auto n = static_cast<double>(++count_);
  const Eigen::Vector2d from = p_from - mean_from_;
  const Eigen::Vector2d to = p_to - mean_to_;
  const double weight = (n - 1.0) / n;
  dot_ += weight * from.dot(to);
  cross_ += weight * (from.x() * to.y() - from.y() * to.x());
  spread_ += weight * (from.squaredNorm() + to.squaredNorm());
  mean_from_ += from / n;
  mean_to_ += to / n;
}

Pose2 RigidAlignment::T_to_from() const {
  Pose2 T{0.0, 0.0, std::atan2(cross_, dot_)};
  const Eigen::Vector2d translation = mean_to_ - T.rotation() * mean_from_;
  T.x_m = translation.x();
  T.y_m = translation.y();
  return T;
}

double RigidAlignment::squaredError() const {
  return std::max(0.0, spread_ - 2.0 * std::hypot(dot_, cross_));
}

}  // namespace hymm::core
