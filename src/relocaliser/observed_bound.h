#pragma once

#include <Eigen/Core>

#include "cekf/vehicle_among_landmarks.h"
#include "common/pose2.h"
#include "relocaliser/convergence.h"

namespace hymm::core {

/// A Gaussian pose moved along by a step in its own axes, of this covariance.
PosePrior moved(const PosePrior& prior, const Pose2& T_begin_end,
                const Eigen::Matrix3d& covariance);

/// `covariance` with its principal axes, in the units of `bound`, no shorter than one. The same if
/// `bound` is not positive definite.
Eigen::Matrix3d raisedTo(const Eigen::Matrix3d& covariance, const Eigen::Matrix3d& bound);

/// What the pose can at best be known to by all that was told: the Cramér-Rao bound of the prior,
/// the motion and the scans since, by the recursion of Tichavský et al. (1998). The landmarks' own
/// errors are the same in each scan and do not average out; they are added.
class ObservedBound {
 public:
  void begin(const PosePrior& prior);
  /// The vehicle may be anywhere.
  void beginAnywhere();
  void move(const Pose2& T_begin_end, const Eigen::Matrix3d& covariance);
  /// A scan was explained from `pose`.
  void observe(const Pose2& pose, const Explanation& explanation);

  /// Of the pose that observe() was given last, in its frame's axes; positive definite.
  Eigen::Matrix3d covariance() const { return known_.covariance + of_landmarks_; }

 private:
  PosePrior known_;  ///< as if the landmarks were known exactly
  Eigen::Matrix3d of_landmarks_ = Eigen::Matrix3d::Zero();
};

}  // namespace hymm::core
