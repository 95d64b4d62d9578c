#pragma once

#include "common/config.h"

namespace hymm::core {

/// Errors of the laser. The defaults are those of a SICK LMS 2xx outdoors: its data sheet where it
/// gives a figure, else the physics that doc/perception.md derives.
struct LaserNoise {
  double range_noise_m = 0.02;             ///< of a single range, independent from beam to beam
  double range_offset_deviation_m = 0.02;  ///< of all ranges on one object together
  double bearing_offset_deviation_rad = 0.002;  ///< of all bearings on one object together
  double beam_width_rad = 0.0;  ///< by which an object looks wider than it is, at any range

  void describe(ConfigSchema& schema);
};

/// What a trunk is, and how it is told from other things.
struct TrunkConfig {
  bool enabled = true;
  double max_range_m = 40.0;
  double min_diameter_m = 0.1;
  double max_diameter_m = 1.0;
  int min_beams = 2;
  int max_missed_beams = 1;
  double max_incidence_rad = 1.4;
  double surface_deviation = 0.1;
  double outline_deviation = 0.06;
  double shape_confidence = 0.999;

  void describe(ConfigSchema& schema);
};

/// What a reflector is.
struct ReflectorConfig {
  bool enabled = false;
  double max_range_m = 40.0;
  double min_intensity = 8192.0;
  double diameter_m = 0.06;
  double max_width_m = 0.3;
  int min_beams = 1;

  void describe(ConfigSchema& schema);
};

/// Parameters of landmark detection in laser scans.
struct PerceptionConfig {
  LaserNoise laser;
  TrunkConfig trunks;
  ReflectorConfig reflectors;

  void describe(ConfigSchema& schema);
};

}  // namespace hymm::core
