#include "simulation/simulation_config.h"

#include "simulation/world_catalog.h"

namespace hymm::core {

void WorldConfig::describe(ConfigSchema& schema) {
  schema.text("name", name, "of the world", worldNames());
  schema.integer("landmarks", landmarks, Range::notNegative(), "number; 0: the world's own");
  schema.number("lap_length_m", lap_length_m, Range::notNegative(),
                "of the route, where the world can stretch; 0: the world's own");
  schema.integer("people", people, Range{-1.0}, "who walk about; -1: the world's own number");
  schema.integer("moving_cars", moving_cars, Range{-1.0}, "-1: the world's own number");
  schema.integer("seed", seed, Range{-1.0}, "of the world alone; -1: the simulation's");
}

void DriveConfig::describe(ConfigSchema& schema) {
  schema.integer("laps", laps, Range{1.0}, "rounds of the world's route");
  schema.number("duration_s", duration_s, Range::notNegative(),
                "the drive ends then at the latest; 0: no limit");
  schema.number("speed_mps", speed_mps, Range::notNegative(), "on straights; 0: the world's own");
  schema.number("acceleration_mps2", acceleration_mps2, Range::positive(), "and deceleration");
  schema.number("lateral_acceleration_mps2", lateral_acceleration_mps2, Range::positive(),
                "limits the speed in curves");
  schema.number("steering_rate_radps", steering_rate_radps, Range::positive(),
                "how fast the front wheel turns");
  schema.number("carried_at_s", carried_at_s, Range::notNegative(),
                "stamp from which the car is carried on along its way: it has been kidnapped");
  schema.number("carried_for_s", carried_for_s, Range::notNegative(),
                "so long; the encoders stand still meanwhile, and nothing else is heard; 0: never");
}

void SimulatedMotionConfig::describe(ConfigSchema& schema) {
  schema.text("output", output, "speed and steering, or a twist", {"dead_reckoning", "odom"});
  schema.number("rate_hz", rate_hz, Range{1.0, 1000.0}, "of the encoders");
  schema.number("noise_scale", noise_scale, Range::notNegative(),
                "times the deviations that the vehicle's `noise` claims");
  schema.flag("draw_calibration", draw_calibration,
              "draw systematic errors with the deviations of the vehicle's `calibration`");
  schema.number("speed_scale", speed_scale, Range::between(0.5, 2.0),
                "systematic error: true speed / measured speed");
  schema.number("turn_scale", turn_scale, Range::between(0.5, 2.0),
                "systematic error: true / measured steering angle or yaw rate");
  schema.number("turn_offset", turn_offset, Range::between(-0.2, 0.2),
                "systematic error added to the measured steering angle [rad] or yaw rate [rad/s]");
}

void SimulatedLaserConfig::describe(ConfigSchema& schema) {
  schema.flag("enabled", enabled, "whether the vehicle has a laser");
  schema.number("rate_hz", rate_hz, Range{0.1, 200.0}, "scans a second");
  schema.number("field_of_view_rad", field_of_view_rad, Range{0.0, 6.2832, true},
                "centred on the sensor's x axis");
  schema.integer("beams", beams, Range{2.0, 100000.0}, "a scan");
  schema.number("range_min_m", range_min_m, Range::notNegative(), "nearer is reported as -inf");
  schema.number("range_max_m", range_max_m, Range::positive(), "farther is reported as +inf");
  schema.flag("rotating", rotating,
              "beams are measured one after another, a whole turn in the time from scan to scan; "
              "else all at one instant");
  schema.number("height_m", height_m, Range::positive(),
                "of the sensor over the ground; of effect on hills only");
  schema.number("range_deviation_m", range_deviation_m, Range::notNegative(), "constant part");
  schema.number("range_deviation_relative", range_deviation_relative, Range::notNegative(),
                "part that grows with the range");
  schema.number("range_resolution_m", range_resolution_m, Range::notNegative(),
                "ranges are rounded to multiples of it; 0: not rounded");
  schema.number("range_offset_m", range_offset_m, Range::between(-1.0, 1.0),
                "systematic error: by how much ranges are too long");
  schema.number("dark_range_m", dark_range_m, Range::notNegative(),
                "where a target that reflects 10 % at normal incidence is seen half the time; "
                "0: everything within range is seen");
  schema.number("missed_return_probability", missed_return_probability, Range::between(0.0, 1.0),
                "of a beam, whatever it meets");
  schema.number("spurious_return_probability", spurious_return_probability,
                Range::between(0.0, 1.0), "of a beam, at any range up to its target");
  schema.number("beam_width_rad", beam_width_rad, Range::between(0.0, 0.1),
                "a retro-reflector within it lights up; also what mixes pixels");
  schema.number("mixed_pixel_probability", mixed_pixel_probability, Range::between(0.0, 1.0),
                "that a beam over an edge reports a range between the two surfaces");
  schema.number("intensity_deviation", intensity_deviation, Range::notNegative(),
                "in units of the device: 32768 is a near retro-reflector");
  schema.number("intensity_step", intensity_step, Range::notNegative(),
                "intensities are rounded down to multiples of it; 0: not rounded");
}

void SimulatedDetectorConfig::describe(ConfigSchema& schema) {
  schema.flag("enabled", enabled, "whether the vehicle has its own detector of landmarks");
  schema.number("rate_hz", rate_hz, Range{0.1, 200.0}, "sets a second");
  schema.number("field_of_view_rad", field_of_view_rad, Range{0.0, 6.2832, true},
                "centred on the sensor's x axis");
  schema.number("range_max_m", range_max_m, Range::positive(), "to a landmark's centre");
  schema.number("range_deviation_m", range_deviation_m, Range::positive(), "of a range, white");
  schema.number("bearing_deviation_rad", bearing_deviation_rad, Range::positive(),
                "of a bearing, white");
  schema.number("diameter_deviation_m", diameter_deviation_m, Range::notNegative(),
                "0: diameters are not told");
  schema.number("detection_probability", detection_probability, Range::between(0.0, 1.0),
                "of a landmark in view");
  schema.number("false_detections", false_detections, Range::notNegative(), "a set, on average");
  schema.flag("occlusion", occlusion, "whether solid things hide landmarks");
  schema.flag("identities", identities, "whether the landmark's true id is told");
}

void SimulatedGpsConfig::describe(ConfigSchema& schema) {
  schema.flag("enabled", enabled, "whether the vehicle has a receiver");
  schema.number("rate_hz", rate_hz, Range{0.01, 50.0}, "fixes a second");
  schema.number("deviation_m", deviation_m, Range::notNegative(), "white error, each axis");
  schema.number("drift_deviation_m", drift_deviation_m, Range::notNegative(),
                "error that persists, each axis");
  schema.number("drift_time_s", drift_time_s, Range::positive(), "how long it persists");
  schema.number("outage_interval_s", outage_interval_s, Range::notNegative(),
                "mean time from one outage to the next; 0: none");
  schema.number("outage_duration_s", outage_duration_s, Range::positive(), "mean");
  schema.number("jump_interval_s", jump_interval_s, Range::notNegative(),
                "mean time from one jump to the next; 0: none");
  schema.number("jump_duration_s", jump_duration_s, Range::positive(), "mean");
  schema.number("jump_deviation_m", jump_deviation_m, Range::notNegative(),
                "of a jump, each axis; the covariance of the fix does not tell");
  schema.number("origin_latitude_deg", origin_latitude_deg, Range::between(-89.0, 89.0),
                "of the local frame");
  schema.number("origin_longitude_deg", origin_longitude_deg, Range::between(-180.0, 180.0),
                "of the local frame");
  schema.number("origin_altitude_m", origin_altitude_m, Range::between(-500.0, 9000.0),
                "of the local frame, above the ellipsoid");
}

void SimulatedAltimeterConfig::describe(ConfigSchema& schema) {
  schema.text("layer", layer, "of the dense map that its samples are for");
  schema.number("deviation_m", deviation_m, Range::positive(), "of a height, white");
  schema.number("place_deviation_m", place_deviation_m, Range::notNegative(),
                "of its place, as samples tell it: so far around, the ground is about as high");
}

void SimulationConfig::describe(ConfigSchema& schema) {
  schema.group("world", world);
  schema.group("drive", drive);
  schema.group("motion", motion);
  schema.group("laser", laser);
  schema.group("detections", detections);
  schema.group("gps", gps);
  schema.group("altimeter", altimeter);
}

VehicleConfig simulatedCar() {
  VehicleConfig car;
  car.name = "simulated_car";
  car.length_m = 4.6;
  car.width_m = 1.8;
  car.rear_overhang_m = 0.8;
  car.max_steering_rad = 0.6;
  car.ackermann.wheelbase_m = 2.83;
  car.ackermann.encoder_offset_left_m = 0.76;
  car.laser = {3.78, 0.5, 0.0};
  car.gps_antenna = {3.78, 0.5, 0.0};
  car.noise.speed_deviation_mps = 0.05;
  car.noise.speed_deviation_relative = 0.03;
  car.noise.steering_deviation_rad = 0.02;
  car.noise.yaw_rate_deviation_radps = 0.02;
  car.noise.yaw_rate_deviation_relative = 0.05;
  car.noise.lateral_deviation_relative = 0.01;
  car.noise.correlation_time_s = 0.2;
  car.calibration.speed_scale_deviation = 0.02;
  car.calibration.turn_scale_deviation = 0.02;
  car.calibration.steering_offset_deviation_rad = 0.01;
  car.calibration.yaw_rate_offset_deviation_radps = 0.005;
  return car;
}

}  // namespace hymm::core
