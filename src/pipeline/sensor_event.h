#pragma once

#include <variant>
#include <vector>

#include <Eigen/Core>

#include "common/pose2.h"
#include "perception/laser_scan.h"
#include "perception/observation.h"
#include "vehicle/motion_input.h"

namespace hymm::core {

/// A laser scan and where its sensor stands on the vehicle.
struct ScanEvent {
  LaserScan scan;
  Pose2 T_base_laser;
  /// Inputs after the stamp, up to the last beam, where beams are measured one after another. They
  /// tell how the sensor moved meanwhile; as events of their own they come behind the scan.
  std::vector<MotionInput> motion_meanwhile = {};
};

/// A GPS fix in a local east-north frame, in metres.
struct GpsFix {
  double time_s = 0.0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();
  Eigen::Vector2d antenna = Eigen::Vector2d::Zero();  ///< its place in base_link
};

/// The clock ran back: everything before belongs to another recording.
struct ClockReset {
  double time_s = 0.0;  ///< of the first event after the jump
};

/// Whatever reaches the engines, in one type, so that live nodes and the offline runner share one
/// path.
using SensorEvent = std::variant<MotionInput, ScanEvent, ObservationSet, GpsFix, ClockReset>;

double timeOf(const SensorEvent& event);

/// When the last of it was measured: not before timeOf().
double endOf(const SensorEvent& event);

}  // namespace hymm::core
