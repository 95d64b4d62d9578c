#pragma once

#include <Eigen/Core>

#include "cekf/vehicle_states.h"
#include "common/pose2.h"

namespace hymm::core {

/// A sensor on the vehicle, with its systematic errors as estimated. States are indices among the
/// vehicle's states, or -1 for what is not estimated.
struct SensorPlacement {
  Pose2 T_base_sensor;          ///< from where the vehicle was at the stamp
  int yaw_state = -1;           ///< error of the mounting's yaw
  double range_offset_m = 0.0;  ///< by which measured ranges are too long
  int range_offset_state = -1;
  int time_offset_state = -1;  ///< of the time of measuring, after the stamp
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< of the vehicle's pose, map axes, per s
};

/// Range [m] and bearing [rad] of a landmark from a sensor on the vehicle, and the Jacobians.
struct RangeBearing {
  Eigen::Vector2d value;               ///< (range, bearing in the sensor's frame)
  Eigen::Matrix<double, 2, 3> H_pose;  ///< by the vehicle's pose (x, y, yaw)
  Eigen::Matrix2d H_landmark;          ///< by the landmark's position
};

/// What a sensor at `T_base_sensor` on a vehicle at `T_map_base` measures of `landmark` (map
/// frame). A landmark at the sensor itself has no bearing: its range is taken as 1 mm.
RangeBearing predictRangeBearing(const Pose2& T_map_base, const Pose2& T_base_sensor,
                                 const Eigen::Vector2d& landmark);

/// Where a measurement puts a landmark in the map, and the Jacobians.
struct LocatedLandmark {
  Eigen::Vector2d position;
  Eigen::Matrix<double, 2, 3> G_pose;  ///< by the vehicle's pose
  Eigen::Matrix2d G_measurement;       ///< by (range, bearing)
};

LocatedLandmark locateLandmark(const Pose2& T_map_base, const Pose2& T_base_sensor, double range_m,
                               double bearing_rad);

/// Jacobian of the measurement by all the vehicle's states, 2 x vehicle_states.
VehicleJacobian vehicleJacobian(const RangeBearing& predicted, const SensorPlacement& sensor,
                                int vehicle_states);

/// Jacobian of the landmark's position by all the vehicle's states, 2 x vehicle_states.
VehicleJacobian vehicleJacobian(const LocatedLandmark& located, const SensorPlacement& sensor,
                                int vehicle_states);

}  // namespace hymm::core
