/// How observations become landmarks of the filter's state.
#include <cmath>

#include "cekf/landmark_life_cycle.h"
#include "cekf/observation_model.h"
#include "cekf/vehicle_state.h"

namespace hymm::core {

using Eigen::Matrix2d;
using Eigen::Vector2d;

std::vector<int> LandmarkLifeCycle::create(const ObservationSet& set, const SensorPlacement& sensor,
                                           const ScanAssociation& association,
                                           const Vector2d& linearised_at, CompressedEkf& filter) {
  std::vector<int> created(set.observations.size(), ScanAssociation::kNone);
  // The first landmarks fix the map: each second without them is drift that stays.
  const bool at_once = registry_.size() == 0;
  for (std::size_t i = 0; i < set.observations.size(); ++i) {
    if (association.slots[i] != ScanAssociation::kNone || association.claimed[i] ||
        association.ignored[i]) {
      continue;
    }
    const Observation& observation = set.observations[i];
    if (observation.identity >= 0) {
      if (registry_.findIdentity(observation.identity) != nullptr) continue;  // twice in this set
    } else {
      const LocatedLandmark located =
          locateLandmark(VehicleState::pose(filter), sensor.T_base_sensor,
                         observation.range_m - sensor.range_offset_m, observation.bearing_rad);
      if (!isFarFromOthers(located.position)) continue;
      const Matrix2d covariance =
          located.G_measurement * observation.covariance * located.G_measurement.transpose();
      if (!tentative_.observe(located.position, covariance, observation.type, scan_number_,
                              set.time_s, at_once)) {
        continue;
      }
    }
    created[i] = promote(observation, set, sensor, linearised_at, filter);
  }
  tentative_.expire(scan_number_);
  return created;
}

bool LandmarkLifeCycle::isFarFromOthers(const Vector2d& position) const {
  return registry_.slotsNear(position, config_.min_separation_m).empty();
}

int LandmarkLifeCycle::promote(const Observation& observation, const ObservationSet& set,
                               const SensorPlacement& sensor, const Vector2d& linearised_at,
                               CompressedEkf& filter) {
  RegisteredLandmark landmark;
  landmark.id = next_id_++;
  landmark.identity = observation.identity;
  landmark.type = observation.type;
  landmark.diameter_m = observation.diameter_m;
  landmark.diameter_variance = observation.diameter_variance;
  landmark.observations = 1;
  landmark.first_seen_s = set.time_s;
  landmark.last_seen_s = set.time_s;
  landmark.farthest_seen_m = observation.range_m;
  landmark.existence_log_odds = hit_log_odds_;
  appendTo(filter, observation, sensor, landmark);
  landmark.linearised_at =
      landmark.position + linearised_at - VehicleState::pose(filter).position();
  registry_.add(landmark);
  changed_ids_.insert(landmark.id);
  if (landmark.identity < 0 && !isConfirmed(landmark)) {
    unconfirmed_ids_.insert(landmark.id);
  }
  ++counts_.created;
  return landmark.slot;
}

/// Puts the landmark where the observation has it, with what the observation's error hangs on.
void LandmarkLifeCycle::appendTo(CompressedEkf& filter, Observation observation,
                                 const SensorPlacement& sensor, RegisteredLandmark& landmark) {
  if (dependsOnDiameter(observation)) {
    landmark.diameter_state = diameters_.add(observation, filter);
    observation =
        conditionedOnDiameter(observation, DiameterStates::mean(landmark.diameter_state, filter));
  }
  const Pose2 pose = VehicleState::pose(filter);
  const LocatedLandmark located =
      locateLandmark(pose, sensor.T_base_sensor, observation.range_m - sensor.range_offset_m,
                     observation.bearing_rad);
  const Matrix2d& G = located.G_measurement;
  SlotJacobian by_diameter, by_error;
  if (landmark.diameter_state.exists()) {
    by_diameter.slot = landmark.diameter_state.slot;
    by_diameter.G.col(landmark.diameter_state.half) = G * diameterGain(observation);
  }
  if (lasting_error_model_.exist()) {
    const Vector2d at = (pose * sensor.T_base_sensor).position();
    landmark.lasting_error = lasting_errors_.add(landmark.id, at, filter);
    by_error = {landmark.lasting_error.slot,
                -G * lasting_error_model_.factor(observation.covariance)};
    observation.covariance = lasting_error_model_.fresh(observation.covariance);
  }
  landmark.slot =
      filter.append(located.position, vehicleJacobian(located, sensor, filter.vehicleStates()),
                    G * observation.covariance * G.transpose(), by_diameter, by_error);
  landmark.position = located.position;
  landmark.deviation_m = std::sqrt(filter.covariance(landmark.slot, landmark.slot).trace());
}

void LandmarkLifeCycle::beginLastingErrors(const SensorPlacement& sensor,
                                           ScanAssociation& association, CompressedEkf& filter) {
  if (!lasting_error_model_.exist()) return;
  const Vector2d at = (VehicleState::pose(filter) * sensor.T_base_sensor).position();
  for (std::size_t k = 0; k < association.measurements.size(); ++k) {
    SparseMeasurement& measurement = association.measurements[k];
    if (measurement.landmarks[SparseMeasurement::kError] != SparseMeasurement::kNone) continue;
    RegisteredLandmark& landmark =
        registry_.bySlot(measurement.landmarks[SparseMeasurement::kLandmark]);
    landmark.lasting_error = lasting_errors_.add(landmark.id, at, filter);
    lasting_error_model_.include(landmark.lasting_error, filter, association.sightings[k],
                                 measurement);
  }
}

void LandmarkLifeCycle::forgetLastingErrors(const SensorPlacement& sensor, CompressedEkf& filter) {
  const Vector2d at = (VehicleState::pose(filter) * sensor.T_base_sensor).position();
  lasting_errors_.removeForgotten(at, lasting_error_model_, registry_, filter);
}

}  // namespace hymm::core
