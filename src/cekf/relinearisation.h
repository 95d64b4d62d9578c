#pragma once

#include <Eigen/Core>

#include "cekf/compressed_ekf.h"
#include "cekf/landmark_registry.h"
#include "cekf/vehicle_state.h"

namespace hymm::core {

// Where Jacobians are not taken at the latest estimates, the covariance belongs to the places at
// which they are taken: an error d of the map's heading, which nothing measures, stands in it as
// J * place * d for a landmark and for the vehicle's position, J turning by 90 degrees. To take
// Jacobians elsewhere, its errors have to be defined anew there,
//   error' = error + J * (new place - old place) * error of the vehicle's yaw,
// else information about the heading comes in. The invariant EKF does the same with each update.

/// Takes a landmark's Jacobians at `place` [m, map] from now on, unless landmarks are fixed.
/// Makes it active.
void relinearise(RegisteredLandmark& landmark, const Eigen::Vector2d& place, CompressedEkf& filter);

/// The same for the vehicle's position.
void relinearise(VehicleState& vehicle, const Eigen::Vector2d& place, CompressedEkf& filter);

}  // namespace hymm::core
