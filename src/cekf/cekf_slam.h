#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "cekf/cekf_slam_config.h"
#include "cekf/landmark_map.h"
#include "cekf/vehicle_state.h"
#include "common/pose2.h"
#include "pipeline/sensor_event.h"
#include "vehicle/motion_model.h"

namespace hymm::core {

/// The vehicle in the map, at the time of the last processed scan.
struct PoseEstimate {
  double time_s = 0.0;
  Pose2 T_map_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< (x [m], y [m], yaw [rad]), map axes
  std::uint64_t map_version = 0;                         ///< of the landmarks it belongs to
};

/// How well the filter explains what the sensors say. Shares are between 0 and 1.
struct FilterHealth {
  double time_s = 0.0;
  double nis = 0.0;                   ///< normalised innovation squared of the scan's joint update
  int dof = 0;                        ///< its degrees of freedom; 0 when nothing was associated
  double ambiguity = 0.0;             ///< observations with two or more compatible landmarks
  double unexplained = 0.0;           ///< observations that no landmark explains
  double missed = 0.0;                ///< landmarks that should have been seen and were not
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
};

/// Landmark SLAM with a compressed EKF: the engine of the node `cekf_slam`. Events come in time
/// order (see SensorMerger). Deterministic: same events, same results. Not thread-safe.
class CekfSlam {
 public:
  /// Counts since construction; reset() does not clear them.
  struct Counts {
    std::size_t scans = 0;  ///< accepted scans and observation sets
    std::size_t refused_scans = 0;
    std::size_t refused_motion = 0;        ///< non-finite, or not later than the last
    std::size_t refused_observations = 0;  ///< non-finite, or with unusable covariance
    std::size_t motion_gaps = 0;           ///< times the motion input was older than hold_limit_s
    std::size_t scans_without_motion = 0;
    std::size_t observations = 0;
    std::size_t associated = 0;
    std::size_t rejected = 0;
    std::size_t gps_used = 0;
    std::size_t gps_rejected = 0;
    std::size_t landmarks_created = 0;
    std::size_t landmarks_dropped = 0;
    std::size_t landmarks_merged = 0;
    std::size_t area_switches = 0;
    std::size_t map_corrections = 0;  ///< scans that moved an active landmark by over 0.5 m
    std::size_t resets = 0;
  };

  /// CPU of the parts, in seconds, since construction.
  struct CpuTimes {
    double perception_s = 0.0;
    double filter_s = 0.0;
  };

  /// Throws ConfigError if the configuration is unusable.
  CekfSlam(const CekfSlamConfig& config, const VehicleConfig& vehicle);
  ~CekfSlam();
  CekfSlam(CekfSlam&&) noexcept;
  CekfSlam& operator=(CekfSlam&&) noexcept;

  /// Any event; the outcome of a scan or observation set, nothing for others.
  std::optional<ScanOutcome> process(const SensorEvent& event);

  /// A new, empty map with the vehicle at its origin. Ids start anew, the version goes on.
  void reset();

  PoseEstimate pose() const;
  Calibration calibration() const;
  Eigen::Matrix3d calibrationCovariance() const;
  LaserCalibration laserCalibration() const;
  std::uint64_t mapVersion() const;
  std::size_t landmarkCount() const;

  /// All landmarks in one epoch; cross-covariances for pairs no farther apart than
  /// `block_range_m` (0: none).
  LandmarkMap landmarkMap(double block_range_m) const;

  /// What changed since `version`.
  LandmarkUpdate updateSince(std::uint64_t version) const;

  const Counts& counts() const;
  const CpuTimes& cpuTimes() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hymm::core
