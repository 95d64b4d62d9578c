#pragma once

#include <vector>

#include "pipeline/sensor_event.h"
#include "simulation/truth.h"
#include "vehicle/vehicle_config.h"

namespace hymm::benchmarks {

/// What reaches a filter between two scans, and the scan.
struct ScanPeriod {
  std::vector<core::MotionInput> motion;  ///< since the last scan, by time
  core::ObservationSet set;
  std::vector<int> identities;  ///< of the landmarks truly observed
  core::Pose2 T_map_base;       ///< truth at the scan
};

/// Recorded input for filters in the world `plain`: first a survey that puts every landmark into
/// the map, then the drive that is measured, from the same start.
struct PlainDrive {
  static constexpr double kScanRate_hz = 4.67;
  static constexpr double kRange_m = 28.0;

  core::VehicleConfig vehicle;
  std::vector<ScanPeriod> survey;  ///< observations carry identities
  std::vector<ScanPeriod> drive;   ///< observations carry none
};

/// `scans` scans at 4.67 Hz, range 28 m, 180 degrees, 5 m/s, among one landmark per 100 m^2. The
/// survey stops in each square of 100 m and measures all landmarks of the square, and a few known
/// ones around, so that the map has the correlations of one made by driving, at the cost of few
/// global updates.
PlainDrive makePlainDrive(int landmarks, int scans);

}  // namespace hymm::benchmarks
