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
  explicit ScanUpdate(int max_iterations) : max_iterations_(max_iterations) {}

  UpdateOutcome update(const ObservationSet& set, const ScanAssociation& association,
                       const VehicleState& vehicle, CompressedEkf& filter);

  /// Updates that were repeated.
  std::size_t iterated() const { return iterated_; }

 private:
  using Measurements = std::vector<SparseMeasurement>;

  int max_iterations_;
  std::size_t iterated_ = 0;
};

}  // namespace hymm::core
