#include "cekf/observation_model.h"

#include <algorithm>
#include <cmath>

#include "common/quarter_turn.h"

namespace hymm::core {
namespace {

constexpr double kSmallestRange_m = 1e-3;

/// The vector `v` turned left by a right angle: derivative of a rotated vector by the angle.
}  // namespace

RangeBearing predictRangeBearing(const Pose2& T_map_base, const Pose2& T_base_sensor,
                                 const Eigen::Vector2d& landmark) {
  const Eigen::Vector2d lever = T_map_base.rotation() * T_base_sensor.position();
  const Eigen::Vector2d d = landmark - (T_map_base.position() + lever);
  const double range = std::max(d.norm(), kSmallestRange_m);

  RangeBearing z;
  z.value << range,
      wrapAngle(std::atan2(d.y(), d.x()) - T_map_base.yaw_rad - T_base_sensor.yaw_rad);
  z.H_landmark.row(0) = d.transpose() / range;
  z.H_landmark.row(1) = turnedLeft(d).transpose() / (range * range);
  z.H_pose.leftCols<2>() = -z.H_landmark;
  z.H_pose.col(2) = -z.H_landmark * turnedLeft(lever);
  z.H_pose(1, 2) -= 1.0;
  return z;
}

LocatedLandmark locateLandmark(const Pose2& T_map_base, const Pose2& T_base_sensor, double range_m,
                               double bearing_rad) {
  const double direction = T_map_base.yaw_rad + T_base_sensor.yaw_rad + bearing_rad;
  const Eigen::Vector2d unit(std::cos(direction), std::sin(direction));
  const Eigen::Vector2d from_base =
      T_map_base.rotation() * T_base_sensor.position() + range_m * unit;

  LocatedLandmark located;
  located.position = T_map_base.position() + from_base;
  located.G_pose.leftCols<2>().setIdentity();
  located.G_pose.col(2) = turnedLeft(from_base);
  located.G_measurement.col(0) = unit;
  located.G_measurement.col(1) = range_m * turnedLeft(unit);
  return located;
}

VehicleJacobian vehicleJacobian(const RangeBearing& predicted, const SensorPlacement& sensor,
                                int vehicle_states) {
  VehicleJacobian H(2, vehicle_states);
  H.setZero();
  H.leftCols<3>() = predicted.H_pose;
  if (sensor.yaw_state >= 0) H(1, sensor.yaw_state) = -1.0;
  if (sensor.range_offset_state >= 0) H(0, sensor.range_offset_state) = 1.0;
  if (sensor.time_offset_state >= 0) {
    H.col(sensor.time_offset_state) = predicted.H_pose * sensor.velocity;
  }
  return H;
}

VehicleJacobian vehicleJacobian(const LocatedLandmark& located, const SensorPlacement& sensor,
                                int vehicle_states) {
  VehicleJacobian G(2, vehicle_states);
  G.setZero();
  G.leftCols<3>() = located.G_pose;
  if (sensor.yaw_state >= 0) G.col(sensor.yaw_state) = located.G_measurement.col(1);
  if (sensor.range_offset_state >= 0) {
    G.col(sensor.range_offset_state) = -located.G_measurement.col(0);
  }
  if (sensor.time_offset_state >= 0) {
    G.col(sensor.time_offset_state) = located.G_pose * sensor.velocity;
  }
  return G;
}

}  // namespace hymm::core
