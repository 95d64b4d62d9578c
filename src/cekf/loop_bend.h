#pragma once

#include <functional>
#include <vector>

#include "cekf/compressed_ekf.h"
#include "cekf/landmark_registry.h"
#include "cekf/vehicle_state.h"

namespace hymm::core {

/// Measurements as they are at the filter's present estimates.
using MeasurementsNow = std::function<std::vector<SparseMeasurement>()>;

/// Bends the map to where an update that closes a loop leads: what was seen long ago stays, what
/// was seen lately turns and goes with the vehicle, and what came between turns by less. A Kalman
/// filter goes there straight: it stretches what it should turn, and its covariance is of the map
/// as it lay before. Worse, what is to be one place lies apart there, and so takes part otherwise
/// in an error of the map's heading, which the update then measures.
///
/// So the way is gone in small steps, each turning the errors along with the map (ErrorTransport)
/// and leading on by the covariance as it is then, which stays that of before the update. At the
/// end the estimates are put back to where they were, seen in the turned axes. That leaves the
/// update itself to the caller; covariance and Jacobians belong to where it ends.
///
/// Nothing happens, and false is returned, if an update as it stands moves no landmark by more than
/// `least_move_m`, if it would be refused, or if no end is found. Landmarks that it moves by less
/// than a tenth of that, and of more than kMostBent those that it moves least, keep their errors.
bool bendMap(const MeasurementsNow& measurements, double least_move_m, VehicleState& vehicle,
             LandmarkRegistry& registry, CompressedEkf& filter);

inline constexpr std::size_t kMostBent = 600;

}  // namespace hymm::core
