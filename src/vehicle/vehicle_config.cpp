#include "vehicle/vehicle_config.h"

namespace hymm::core {

void SensorMounting::describe(ConfigSchema& schema) {
  schema.number("x_m", x_m, Range::any(), "ahead of base_link");
  schema.number("y_m", y_m, Range::any(), "left of base_link");
  schema.number("yaw_rad", yaw_rad, Range::between(-kPi, kPi), "counter-clockwise from forward");
}

void AckermannGeometry::describe(ConfigSchema& schema) {
  schema.number("wheelbase_m", wheelbase_m, Range::positive(), "from the rear to the front axle");
  schema.number(
      "encoder_offset_left_m", encoder_offset_left_m, Range::any(),
      "of the wheel that carries the encoder, from the rear axle's centre; left positive");
}

void MotionNoise::describe(ConfigSchema& schema) {
  schema.number("speed_deviation_mps", speed_deviation_mps, Range::notNegative(),
                "constant part of the speed's error");
  schema.number("speed_deviation_relative", speed_deviation_relative, Range::notNegative(),
                "part of the speed's error that grows with the speed");
  schema.number("steering_deviation_rad", steering_deviation_rad, Range::notNegative(),
                "constant part of the steering angle's error (Ackermann)");
  schema.number("steering_deviation_relative", steering_deviation_relative, Range::notNegative(),
                "part of the steering angle's error that grows with it (Ackermann)");
  schema.number("yaw_rate_deviation_radps", yaw_rate_deviation_radps, Range::notNegative(),
                "constant part of the yaw rate's error (twist)");
  schema.number("yaw_rate_deviation_relative", yaw_rate_deviation_relative, Range::notNegative(),
                "part of the yaw rate's error that grows with it (twist)");
  schema.number("lateral_deviation_relative", lateral_deviation_relative, Range::notNegative(),
                "side slip, as a share of the speed");
  schema.number("correlation_time_s", correlation_time_s, Range::positive(),
                "how long these errors persist, but for the two below");
  schema.number("speed_correlation_time_s", speed_correlation_time_s, Range::notNegative(),
                "how long the speed's error persists; 0: as the others");
  schema.number(
      "turn_relative_correlation_time_s", turn_relative_correlation_time_s, Range::notNegative(),
      "how long the relative part of the steering's or yaw rate's error persists: where it "
      "is a linkage that is not linear, about as long as a manoeuvre; 0: as the others");
  schema.number("hold_limit_s", hold_limit_s, Range::positive(),
                "longest time for which an input is trusted after its stamp");
  schema.number("gap_acceleration_mps2", gap_acceleration_mps2, Range::notNegative(),
                "growth of the speed's deviation once an input is no longer trusted");
  schema.number("gap_yaw_rate_deviation_radps", gap_yaw_rate_deviation_radps, Range::notNegative(),
                "deviation of the yaw rate once an input is no longer trusted");
}

Eigen::Vector3d MotionNoise::correlationTimes_s() const {
  const auto known = [this](double time_s) { return time_s > 0.0 ? time_s : correlation_time_s; };
  return {known(speed_correlation_time_s), correlation_time_s,
          known(turn_relative_correlation_time_s)};
}

void CalibrationPrior::describe(ConfigSchema& schema) {
  schema.number("speed_scale_deviation", speed_scale_deviation, Range::between(0.0, 0.5),
                "of the speed's scale around 1; 0 leaves it out of the estimate");
  schema.number("turn_scale_deviation", turn_scale_deviation, Range::between(0.0, 0.5),
                "of the steering's or yaw rate's scale around 1; 0 leaves it out");
  schema.number("steering_offset_deviation_rad", steering_offset_deviation_rad,
                Range::between(0.0, 0.5), "of the steering's zero; 0 leaves it out");
  schema.number("yaw_rate_offset_deviation_radps", yaw_rate_offset_deviation_radps,
                Range::between(0.0, 0.5), "of the yaw rate's zero; 0 leaves it out");
  schema.number("laser_yaw_deviation_rad", laser_yaw_deviation_rad, Range::between(0.0, 0.5),
                "of the laser's yaw on the vehicle; 0 leaves it out");
  schema.number("laser_range_offset_deviation_m", laser_range_offset_deviation_m,
                Range::between(0.0, 1.0),
                "of an error that all the laser's ranges have in common; 0 leaves it out");
  schema.number("laser_time_offset_deviation_s", laser_time_offset_deviation_s,
                Range::between(0.0, 1.0),
                "of the laser's time of measuring from its stamp, by the clock that stamps the "
                "motion input; 0 leaves it out");
}

void VehicleConfig::describe(ConfigSchema& schema) {
  schema.text("name", name, "of the vehicle, for people");
  schema.number("length_m", length_m, Range::positive(), "of the body");
  schema.number("width_m", width_m, Range::positive(), "of the body");
  schema.number("rear_overhang_m", rear_overhang_m, Range::notNegative(),
                "of the body behind the rear axle");
  schema.number("max_steering_rad", max_steering_rad, Range{0.0, 1.5, true},
                "largest steering angle to either side");
  schema.group("ackermann", ackermann);
  schema.group("noise", noise);
  schema.group("calibration", calibration);
  schema.group("laser", laser);
  schema.group("gps_antenna", gps_antenna);
  schema.text("map_frame", map_frame, "tf frame of the landmark map");
  schema.text("base_frame", base_frame, "tf frame of the rear axle's centre");
  schema.text("odom_frame", odom_frame, "tf frame of dead reckoning");
  schema.text("laser_frame", laser_frame, "tf frame of the laser");
  schema.text("gps_frame", gps_frame, "tf frame of the GPS antenna");
}

}  // namespace hymm::core
