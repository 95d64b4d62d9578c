#pragma once

#include <cstddef>
#include <vector>

#include "cekf/compressed_ekf.h"
#include "cekf/scan_associator.h"
#include "cekf/vehicle_state.h"
#include "perception/observation.h"

namespace hymm::core {

/// The joint update with all associated observations of a set. Where a correction is so large that
/// the measurements are not linear over it, it is repeated with Jacobians at the corrected states
/// (iterated EKF: the innovation becomes z - h(x_i) - H_i * (x - x_i)).
class ScanUpdate {
 public:
  /// Updates that move no landmark by more than `least_move_m` are never repeated: with Jacobians
  /// at first estimates, for those that end the first estimates' use.
  explicit ScanUpdate(int max_iterations, double least_move_m = 0.0)
      : max_iterations_(max_iterations), least_move_m_(least_move_m) {}

  UpdateOutcome update(const ObservationSet& set, const ScanAssociation& association,
                       const VehicleState& vehicle, CompressedEkf& filter);

  /// Updates that were repeated.
  std::size_t iterated() const { return iterated_; }

 private:
  using Measurements = std::vector<SparseMeasurement>;

  bool isLarge(const Measurements& measurements, const CompressedEkf& filter) const;

  int max_iterations_;
  double least_move_m_;
  std::size_t iterated_ = 0;
};

}  // namespace hymm::core
