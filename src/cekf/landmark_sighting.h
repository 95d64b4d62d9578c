#pragma once

#include "cekf/compressed_ekf.h"
#include "cekf/landmark_registry.h"
#include "cekf/observation_model.h"
#include "common/pose2.h"
#include "perception/observation.h"

namespace hymm::core {

/// What a sighting measures of a landmark where the filter has it, seen from `T_map_base`.
/// Activates the landmark, and its diameter where the place hangs on that. `sighting`: the
/// observation, which becomes what it is for the diameter that the filter holds.
SparseMeasurement sightLandmark(Observation& sighting, const Pose2& T_map_base,
                                const SensorPlacement& sensor, const RegisteredLandmark& landmark,
                                CompressedEkf& filter);

}  // namespace hymm::core
