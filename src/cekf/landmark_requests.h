#pragma once

#include <functional>

#include "cekf/compressed_ekf.h"
#include "cekf/landmark_map.h"
#include "cekf/landmark_registry.h"
#include "cekf/vehicle_among_landmarks.h"

namespace hymm::core {

// What somebody asks of the map is made on the filter's worker, as of the moment of asking, and
// handed over there.

/// All landmarks. `header` tells version, time and merges; cross-covariances of pairs within
/// `block_range_m` (0: none).
void requestMap(const LandmarkRegistry& registry, LandmarkMap header, double block_range_m,
                CompressedEkf& filter, std::function<void(LandmarkMap)> take);

/// The joint Gaussian of some. `header` tells version, time and ids. False, and nothing happens, if
/// there is no landmark of one of these ids.
bool requestJointLandmarks(const LandmarkRegistry& registry, JointLandmarks header,
                           CompressedEkf& filter, std::function<void(JointLandmarks)> take);

/// The same together with the vehicle, of which `header` tells pose and covariance.
bool requestVehicleAmongLandmarks(const LandmarkRegistry& registry, VehicleAmongLandmarks header,
                                  CompressedEkf& filter,
                                  std::function<void(VehicleAmongLandmarks)> take);

}  // namespace hymm::core
