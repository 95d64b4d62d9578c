#pragma once

#include <string>

#include "common/config.h"
#include "common/pose2.h"

namespace hymm::core {

/// Where a sensor stands on the vehicle, in base_link: x forward, y left, yaw counter-clockwise.
struct SensorMounting {
  double x_m = 0.0;
  double y_m = 0.0;
  double yaw_rad = 0.0;

  Pose2 T_base_sensor() const { return {x_m, y_m, yaw_rad}; }
  void describe(ConfigSchema& schema);
};

/// Geometry of a car whose base_link is the centre of its rear axle.
struct AckermannGeometry {
  double wheelbase_m = 2.83;
  double encoder_offset_left_m = 0.0;  ///< of the encoder's wheel from the rear axle's centre

  void describe(ConfigSchema& schema);
};

/// Errors of the motion input: each is a deviation that persists over a correlation time, so that
/// over T seconds it adds 2 * deviation^2 * correlation_time * T to the variance, whatever the
/// rate.
struct MotionNoise {
  double speed_deviation_mps = 0.02;
  double speed_deviation_relative = 0.02;     ///< of the speed
  double steering_deviation_rad = 0.01;       ///< Ackermann
  double steering_deviation_relative = 0.0;   ///< Ackermann, of the steering angle
  double yaw_rate_deviation_radps = 0.01;     ///< twist
  double yaw_rate_deviation_relative = 0.05;  ///< twist, of the yaw rate
  double lateral_deviation_relative = 0.01;   ///< side slip, of the speed
  double correlation_time_s = 0.5;
  double speed_correlation_time_s = 0.0;          ///< of the speed's error; 0: the same
  double turn_relative_correlation_time_s = 0.0;  ///< of the turn's relative part; 0: the same

  /// By MotionError: of speed, turn, the turn's relative part.
  Eigen::Vector3d correlationTimes_s() const;
  double hold_limit_s = 0.5;                  ///< longest time an input is trusted
  double gap_acceleration_mps2 = 1.0;         ///< growth of the speed's deviation beyond that
  double gap_yaw_rate_deviation_radps = 0.3;  ///< of the yaw rate beyond that

  void describe(ConfigSchema& schema);
};

/// How far the input's scales and offsets may be from their nominal values: initial deviations of
/// the calibration states. Zero keeps a state out of the estimate.
struct CalibrationPrior {
  double speed_scale_deviation = 0.0;
  double turn_scale_deviation = 0.0;             ///< of steering (Ackermann) or yaw rate (twist)
  double steering_offset_deviation_rad = 0.0;    ///< Ackermann
  double yaw_rate_offset_deviation_radps = 0.0;  ///< twist
  double laser_yaw_deviation_rad = 0.0;          ///< of the laser's mounting
  double laser_range_offset_deviation_m = 0.0;   ///< of what its ranges have in common
  double laser_time_offset_deviation_s = 0.0;    ///< of its stamps against the motion input's

  void describe(ConfigSchema& schema);
};

/// A vehicle as config/vehicles/NAME.yaml describes it.
struct VehicleConfig {
  std::string name = "vehicle";
  double length_m = 4.5;
  double width_m = 1.8;
  double rear_overhang_m = 0.8;  ///< body behind the rear axle
  double max_steering_rad = 0.6;
  AckermannGeometry ackermann;
  MotionNoise noise;
  CalibrationPrior calibration;
  SensorMounting laser;
  SensorMounting gps_antenna;
  std::string map_frame = "map";
  std::string base_frame = "base_link";
  std::string odom_frame = "odom";
  std::string laser_frame = "laser";
  std::string gps_frame = "gps";

  void describe(ConfigSchema& schema);
};

}  // namespace hymm::core
