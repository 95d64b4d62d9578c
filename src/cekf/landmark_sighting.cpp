#include "cekf/landmark_sighting.h"

#include "cekf/diameter_states.h"
#include "cekf/landmark_measurement.h"

namespace hymm::core {

SparseMeasurement sightLandmark(Observation& sighting, const Pose2& T_map_base,
                                const SensorPlacement& sensor, const RegisteredLandmark& landmark,
                                CompressedEkf& filter) {
  filter.activate(landmark.slot);
  const DiameterState& diameter = landmark.diameter_state;
  const bool by_diameter = diameter.exists() && dependsOnDiameter(sighting);
  if (by_diameter) {
    filter.activate(diameter.slot);
    sighting = conditionedOnDiameter(sighting, DiameterStates::mean(diameter, filter));
  }
  SparseMeasurement measurement =
      landmarkMeasurement(sighting, T_map_base, sensor,
                          {landmark.slot, filter.landmark(landmark.slot)}, filter.vehicleStates());
  if (by_diameter) {
    measurement.landmarks[SparseMeasurement::kDiameter] = diameter.slot;
    measurement.H_landmarks[SparseMeasurement::kDiameter].col(diameter.half) =
        -diameterGain(sighting);
  }
  return measurement;
}

}  // namespace hymm::core
