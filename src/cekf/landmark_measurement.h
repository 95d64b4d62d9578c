#pragma once

#include <Eigen/Core>

#include "cekf/compressed_ekf.h"
#include "cekf/observation_model.h"
#include "common/pose2.h"
#include "perception/observation.h"

namespace hymm::core {

/// A landmark of the filter, taken to be at a place.
struct PlacedLandmark {
  int slot = SparseMeasurement::kNone;
  Eigen::Vector2d position;  ///< map frame, m
};

/// What an observation measures of a landmark, seen from `T_map_base`: the innovation against these
/// places, with its Jacobians there.
SparseMeasurement landmarkMeasurement(const Observation& observation, const Pose2& T_map_base,
                                      const SensorPlacement& sensor, const PlacedLandmark& landmark,
                                      int vehicle_states);

/// Takes the Jacobians at other places, and leaves the innovation as it is.
void linearise(SparseMeasurement& measurement, const Pose2& T_map_base,
               const SensorPlacement& sensor, const Eigen::Vector2d& landmark, int vehicle_states);

}  // namespace hymm::core
