#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/pose2.h"
#include "perception/observation.h"
#include "vehicle/sweep_motion.h"

namespace hymm::core {

/// The vehicle in the map, at the time of the last processed scan.
struct PoseEstimate {
  double time_s = 0.0;
  Pose2 T_map_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< (x [m], y [m], yaw [rad]), map axes
  /// The same relative to the landmarks around (see relativeCovariance); that of a scan's outcome.
  Eigen::Matrix3d relative_covariance = Eigen::Matrix3d::Zero();
  std::uint64_t map_version = 0;  ///< of the landmarks it belongs to
  /// Where the scan's sensor stood, and by how much its ranges are too long, as the filter
  /// estimates its systematic errors.
  Pose2 T_base_sensor;
  double range_offset_m = 0.0;
  SweepMotion sweep;  ///< of base_link while the scan was measured
};

/// How well the filter explains what the sensors say. Shares are between 0 and 1.
struct FilterHealth {
  double time_s = 0.0;
  double nis = 0.0;          ///< normalised innovation squared of the scan's joint update
  int dof = 0;               ///< its degrees of freedom; 0 when nothing was associated
  double ambiguity = 0.0;    ///< observations with two or more compatible landmarks
  double unexplained = 0.0;  ///< observations that no landmark explains
  double missed = 0.0;       ///< landmarks that should have been seen and were not
  /// Confirmed landmarks that the scan should have shown, whether it did or not; those that
  /// something nearer hides are not among them. 0 where no scan tells what is hidden.
  int confirmed_expected = 0;
  int confirmed_missed = 0;           ///< of these
  double position_deviation_m = 0.0;  ///< largest, of the vehicle
  double heading_deviation_rad = 0.0;
  double latency_ms = 0.0;  ///< wall time of processing the scan
};

/// What became of one observation.
struct Association {
  static constexpr int kTentative = -1;  ///< feeds a landmark that is not yet in the state
  static constexpr int kRejected = -2;   ///< fits, but not jointly; or too near an old landmark
  int landmark_id = kRejected;           ///< >= 0: the landmark that it updated
};

/// Outcome of a scan or observation set. `accepted` false: it was refused, `reason` says why, and
/// nothing changed.
struct ScanOutcome {
  bool accepted = false;
  std::string reason;
  PoseEstimate pose;
  FilterHealth health;
  ObservationSet observations;
  std::vector<Association> associations;  ///< as long as observations.observations
  double largest_correction_m = 0.0;      ///< of an active landmark, by this scan
  /// The filter waits, see CekfSlam::suspend(): the pose is carried on by the motion alone, nothing
  /// was associated, and health says nothing but the deviations.
  bool suspended = false;
};

}  // namespace hymm::core
