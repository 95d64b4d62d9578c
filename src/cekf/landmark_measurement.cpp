#include "cekf/landmark_measurement.h"

#include "common/angles.h"

namespace hymm::core {

SparseMeasurement landmarkMeasurement(const Observation& observation, const Pose2& T_map_base,
                                      const SensorPlacement& sensor, const PlacedLandmark& landmark,
                                      int vehicle_states) {
  const RangeBearing z = predictRangeBearing(T_map_base, sensor.T_base_sensor, landmark.position);
  SparseMeasurement measurement;
  measurement.innovation << observation.range_m - sensor.range_offset_m - z.value[0],
      wrapAngle(observation.bearing_rad - z.value[1]);
  measurement.H_vehicle = vehicleJacobian(z, sensor, vehicle_states);
  measurement.landmarks[0] = landmark.slot;
  measurement.H_landmarks[0] = z.H_landmark;
  measurement.noise = observation.covariance;
  return measurement;
}

void linearise(SparseMeasurement& measurement, const Pose2& T_map_base,
               const SensorPlacement& sensor, const Eigen::Vector2d& landmark, int vehicle_states) {
  const RangeBearing z = predictRangeBearing(T_map_base, sensor.T_base_sensor, landmark);
  measurement.H_vehicle = vehicleJacobian(z, sensor, vehicle_states);
  measurement.H_landmarks[0] = z.H_landmark;
}

}  // namespace hymm::core
