#pragma once

#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "cekf/vehicle_among_landmarks.h"

namespace hymm::core {

/// The ellipsoid that a prior leaves.
class PriorLimit {
 public:
  /// Without a prior nothing is excluded.
  PriorLimit(const std::optional<PosePrior>& prior, double deviations);

  /// Whether no pose that is nearer than these to `pose` is within it.
  bool excludes(const Pose2& pose, double within_m, double within_rad) const;

  bool isOn() const { return factor_.has_value(); }
  const Pose2& mean() const { return mean_; }
  double reach_m() const { return reach_m_; }
  double reach_rad() const { return reach_rad_; }

 private:
  double limit_;
  Pose2 mean_;
  std::optional<Eigen::LLT<Eigen::Matrix3d>> factor_;
  double per_m_ = 0.0, per_rad_ = 0.0;  ///< most deviations that a metre or a radian makes
  double reach_m_ = 0.0, reach_rad_ = 0.0;
};

}  // namespace hymm::core
