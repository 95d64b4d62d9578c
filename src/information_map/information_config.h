#pragma once

#include <string>

#include "common/angles.h"
#include "common/config.h"

namespace hymm::core {

/// What a sensor sees of landmarks, as far as planning may rely on it.
struct ExpectedSensor {
  double range_m = 15.0;
  double min_range_m = 1.0;
  double field_of_view_rad = kPi;
  double range_deviation_m = 0.05;
  double bearing_deviation_rad = 0.005;
  double region_sigmas = 2.0;

  void describe(ConfigSchema& schema);
};

/// How achievable information becomes one number.
struct InformationConfig {
  ExpectedSensor sensor;
  std::string heading = "omnidirectional";
  double fixed_heading_rad = 0.0;
  std::string measure = "determinant";
  double length_m = 10.0;

  void describe(ConfigSchema& schema);
};

}  // namespace hymm::core
