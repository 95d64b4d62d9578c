#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "cekf/compressed_ekf.h"
#include "cekf/landmark_registry.h"
#include "cekf/scan_associator.h"
#include "cekf/vehicle_state.h"
#include "perception/observation.h"

namespace hymm::core {

/// The joint update with all associated observations of a set. Where a correction is so large that
/// the measurements are not linear over it, it is repeated with Jacobians at the corrected states
/// (iterated EKF: the innovation becomes z - h(x_i) - H_i * (x - x_i)), and refused if that leads
/// away from what was measured.
class ScanUpdate {
 public:
  explicit ScanUpdate(int max_iterations) : max_iterations_(max_iterations) {}
  /// With Jacobians at first estimates: updates that move no landmark by more than `least_move_m`
  /// are never repeated, and to those that are the covariance is carried along.
  ScanUpdate(int max_iterations, double least_move_m)
      : max_iterations_(max_iterations), least_move_m_(least_move_m) {}

  UpdateOutcome update(const ObservationSet& set, const ScanAssociation& association,
                       VehicleState& vehicle, LandmarkRegistry& registry, CompressedEkf& filter);

  /// Updates that were repeated.
  std::size_t iterated() const { return iterated_; }
  /// Of these, that were refused, since they led away from what was measured.
  std::size_t diverged() const { return diverged_; }

 private:
  using Measurements = std::vector<SparseMeasurement>;

  bool isLarge(const Eigen::VectorXd& states_after, const CompressedEkf& filter) const;
  /// Measurements that were linearised anew, and the most that they neglected before, in squared
  /// deviations of their noise.
  struct Repeated {
    Measurements measurements;
    double neglected2 = 0.0;
  };

  static Repeated linearisedAt(const Eigen::VectorXd& states, const ObservationSet& set,
                               const ScanAssociation& association, const Measurements& measurements,
                               const VehicleState& vehicle, const CompressedEkf& filter);

  int max_iterations_;
  std::optional<double> least_move_m_;  ///< with Jacobians at first estimates
  std::size_t iterated_ = 0;
  std::size_t diverged_ = 0;
};

}  // namespace hymm::core
