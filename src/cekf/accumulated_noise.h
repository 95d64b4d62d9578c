#pragma once

#include <array>

#include <Eigen/Core>

#include "cekf/motion_noise_scale.h"
#include "cekf/vehicle_states.h"

namespace hymm::core {

/// Covariance that the noise of the motion alone has given the first of the vehicle's states, its
/// pose and the errors of its motion: what is due to translation, and what to rotation. Carried
/// along each motion, so the matrices have one size; of states that there are not they hold zeros.
class AccumulatedNoise {
 public:
  static constexpr int kStates = 6;
  using Matrix = Eigen::Matrix<double, kStates, kStates>;
  using Parts = std::array<Matrix, MotionNoiseScale::kParts>;

  void begin(const Parts& parts) { parts_ = parts; }
  /// Along a motion with this Jacobian, diagonal below the pose's three rows, which adds noise.
  void carry(const Matrix& J, const Parts& added);
  /// It was that many times as large.
  void multiply(double factor);

  /// Of all `size` states of the vehicle.
  VehicleMatrix total(int size) const;
  /// What an update says of the factors that this noise was predicted with. `score` and
  /// `information`: UpdateOutcome's. With innovations y of covariance S, and M = H D H' the part
  /// that the noise D has in S: slope = (y' S^-1 M S^-1 y - tr(S^-1 M)) / 2, information
  /// tr(S^-1 M_i S^-1 M_j) / 2.
  MotionNoiseScale::Evidence evidence(const VehicleVector& score,
                                      const VehicleMatrix& information) const;

  template <class Archive>
  void describeState(Archive& archive) {
    for (Matrix& part : parts_) {
      archive(part);
      if constexpr (Archive::kReads) {
        archive.require(part.allFinite(), "the noise of the motion is not finite");
      }
    }
  }

 private:
  Parts parts_;
};

}  // namespace hymm::core
