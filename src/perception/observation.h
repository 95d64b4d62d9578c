#pragma once

#include <limits>
#include <vector>

#include <Eigen/Core>

#include "common/pose2.h"

namespace hymm::core {

enum class LandmarkType { kUnknown = 0, kTrunk = 1, kReflector = 2 };

/// Whether two things can be one object, as far as their types tell.
inline bool mayBeOneKind(LandmarkType a, LandmarkType b) {
  return a == b || a == LandmarkType::kUnknown || b == LandmarkType::kUnknown;
}

/// One landmark as a sensor sees it, in the sensor's frame: its centre in range and bearing.
struct Observation {
  double range_m = 0.0;
  double bearing_rad = 0.0;  ///< counter-clockwise from the sensor's x axis
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  ///< of (range [m], bearing [rad])
  LandmarkType type = LandmarkType::kUnknown;
  double diameter_m = std::numeric_limits<double>::quiet_NaN();  ///< NaN where it cannot be told
  double diameter_variance = std::numeric_limits<double>::quiet_NaN();  ///< m^2
  /// Of the diameter with (range, bearing): not zero where the centre's place hangs on it.
  Eigen::Vector2d diameter_covariance = Eigen::Vector2d::Zero();
  int identity = -1;  ///< of the landmark, where the sensor reads one; else -1
  /// When it was measured, after the set's stamp: then the sensor had moved on, see asOfStamp().
  double after_stamp_s = 0.0;
};

/// An observation as it would have been made at the stamp of its set, where the sensor was then.
/// `T_stamp_sensor` is where it was when it measured, from there; `covariance` is of that pose (x
/// [m], y [m], yaw [rad]), in the axes of the stamp, and independent of the observation.
Observation asOfStamp(const Observation& observation, const Pose2& T_stamp_sensor,
                      const Eigen::Matrix3d& covariance);

/// All landmarks seen at one time by one sensor.
struct ObservationSet {
  double time_s = 0.0;
  Pose2 T_base_sensor;
  std::vector<Observation> observations;
};

}  // namespace hymm::core
