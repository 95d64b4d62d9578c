#pragma once

#include <string>
#include <vector>

#include "common/config.h"
#include "vehicle/vehicle_config.h"

namespace hymm::core {

/// Which world is made, and how much of everything stands and moves in it.
struct WorldConfig {
  std::string name = "park";
  int landmarks = 0;          ///< 0 for the world's own number
  double lap_length_m = 0.0;  ///< 0 for the world's own length; fixed by the layout in some worlds
  int people = -1;            ///< walking; -1 for the world's own number
  int moving_cars = -1;       ///< -1 for the world's own number
  int seed = -1;              ///< of the world alone; -1 for the simulation's seed

  void describe(ConfigSchema& schema);
};

/// How the car drives along the world's route.
struct DriveConfig {
  int laps = 3;
  double duration_s = 0.0;  ///< the drive ends here if that is sooner; 0 for no limit
  double speed_mps = 0.0;   ///< on straights; 0 for the world's own speed
  double acceleration_mps2 = 1.0;
  double lateral_acceleration_mps2 = 1.5;  ///< limits the speed in curves
  double steering_rate_radps = 0.6;
  /// The car is carried on along its way, with the wheels at rest and all sensors covered.
  double carried_at_s = 0.0;
  double carried_for_s = 0.0;  ///< 0: never

  bool isCarriedAt(double time_s) const {
    return time_s >= carried_at_s && time_s < carried_at_s + carried_for_s;
  }

  void describe(ConfigSchema& schema);
};

/// What the encoders (or the odometry) report. Their random errors are those that the vehicle's
/// `noise` claims, so that a filter that is given the same vehicle knows the truth about them.
struct SimulatedMotionConfig {
  std::string output = "dead_reckoning";  ///< or "odom": a twist in place of speed and steering
  double rate_hz = 40.0;
  double noise_scale = 1.0;      ///< times the deviations that the vehicle claims
  bool draw_calibration = true;  ///< systematic errors, drawn by the vehicle's prior
  double speed_scale = 1.0;      ///< further systematic error: true = scale * measured
  double turn_scale = 1.0;       ///< of steering angle or yaw rate
  double turn_offset = 0.0;      ///< rad or rad/s: true = scale * measured + offset

  void describe(ConfigSchema& schema);
};

/// A planar laser.
struct SimulatedLaserConfig {
  bool enabled = true;
  double rate_hz = 5.0;
  double field_of_view_rad = kPi;
  int beams = 361;
  double range_min_m = 0.2;
  double range_max_m = 80.0;
  bool rotating =
      false;  ///< beams one after another, a turn from scan to scan; else at one instant
  double height_m = 0.8;  ///< over the ground; of effect on hills only
  double range_deviation_m = 0.01;
  double range_deviation_relative = 0.0003;
  double range_resolution_m = 0.01;  ///< 0 for none
  double range_offset_m = 0.0;       ///< systematic error: by how much ranges are too long
  double dark_range_m = 30.0;        ///< where a 10 % target is seen half the time; 0: no limit
  double missed_return_probability = 0.002;  ///< whatever the target
  double spurious_return_probability = 0.0002;
  double beam_width_rad = 0.0087;        ///< within which a retro-reflector lights up
  double mixed_pixel_probability = 0.0;  ///< of a beam that straddles an edge
  double intensity_deviation = 1500.0;
  double intensity_step = 8192.0;  ///< 0 for none

  void describe(ConfigSchema& schema);
};

/// A detector of landmarks that hands out ranges and bearings, in place of scans.
struct SimulatedDetectorConfig {
  bool enabled = false;
  double rate_hz = 5.0;
  double field_of_view_rad = kPi;
  double range_max_m = 30.0;
  double range_deviation_m = 0.05;
  double bearing_deviation_rad = 0.005;
  double diameter_deviation_m = 0.05;
  double detection_probability = 0.95;
  double false_detections = 0.0;  ///< a set, on average
  bool occlusion = true;
  bool identities = false;  ///< whether the landmark's identity is told

  void describe(ConfigSchema& schema);
};

/// A GPS receiver with the weaknesses of real ones. Fixes are of the antenna, in the local
/// east-north frame of the world.
struct SimulatedGpsConfig {
  bool enabled = true;
  double rate_hz = 1.0;
  double deviation_m = 0.3;        ///< white
  double drift_deviation_m = 0.3;  ///< correlated
  double drift_time_s = 60.0;
  double outage_interval_s = 60.0;  ///< mean time between outages; 0 for none
  double outage_duration_s = 20.0;  ///< mean
  double jump_interval_s = 120.0;   ///< mean time between jumps; 0 for none
  double jump_duration_s = 5.0;     ///< mean
  double jump_deviation_m = 5.0;
  double origin_latitude_deg = -33.8886;  ///< of the local frame
  double origin_longitude_deg = 151.1944;
  double origin_altitude_m = 30.0;

  void describe(ConfigSchema& schema);
};

/// What measures the height of the ground under the vehicle, with each scan, in worlds with hills.
struct SimulatedAltimeterConfig {
  std::string layer = "height";  ///< that its samples are for
  double deviation_m = 0.05;
  double place_deviation_m = 0.5;  ///< that samples claim, so that all cells under the car learn

  void describe(ConfigSchema& schema);
};

/// Everything that `simulate_world --config` can set.
struct SimulationConfig {
  WorldConfig world;
  DriveConfig drive;
  SimulatedMotionConfig motion;
  SimulatedLaserConfig laser;
  SimulatedDetectorConfig detections;
  SimulatedGpsConfig gps;
  SimulatedAltimeterConfig altimeter;

  void describe(ConfigSchema& schema);
};

/// The car that the simulator drives if no other is given: config/vehicles/simulated_car.yaml.
VehicleConfig simulatedCar();

}  // namespace hymm::core
