#include "relocaliser/prior_limit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "common/angles.h"
#include "relocaliser/density_map.h"

namespace hymm::core {

PriorLimit::PriorLimit(const std::optional<PosePrior>& prior, double deviations)
    : limit_(deviations) {
  if (!prior) return;
  mean_ = prior->mean;
  // A prior that is exact in some direction still has some width.
  const Eigen::Matrix3d P = prior->covariance + 1e-6 * Eigen::Matrix3d::Identity();
  factor_.emplace(P);
  const Eigen::Matrix3d inverse = P.inverse();
  per_m_ = std::sqrt(greatestVariance(inverse.topLeftCorner<2, 2>()));
  per_rad_ = std::sqrt(inverse(2, 2));
  reach_m_ = limit_ * std::sqrt(greatestVariance(P.topLeftCorner<2, 2>()));
  reach_rad_ = limit_ * std::sqrt(P(2, 2));
}

bool PriorLimit::excludes(const Pose2& pose, double within_m, double within_rad) const {
  if (!factor_) return false;
  Eigen::Vector3d d = pose.vector() - mean_.vector();
  d[2] = wrapAngle(d[2]);
  double deviations = std::sqrt(d.dot(factor_->solve(d)));
  if (std::abs(d[2]) + within_rad > kPi) {  // some of them are nearer the other way round
    d[2] -= std::copysign(2.0 * kPi, d[2]);
    deviations = std::min(deviations, std::sqrt(d.dot(factor_->solve(d))));
  }
  return deviations - within_m * per_m_ - within_rad * per_rad_ > limit_;
}

}  // namespace hymm::core
