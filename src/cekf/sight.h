#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cekf/compressed_ekf.h"
#include "cekf/scan_clock.h"
#include "cekf/vehicle_state.h"
#include "perception/perception.h"
#include "pipeline/sensor_event.h"

namespace hymm::core {

/// What a scan or observation event shows; `problem` says why it cannot be used. Of other events
/// nothing at all.
struct Sight {
  std::optional<ObservationSet> set;
  const LaserScan* scan = nullptr;  ///< of the event, or its swept one
  std::string problem;
  const std::vector<MotionInput>* motion_meanwhile = nullptr;  ///< of the event
  SweepMotion sweep;                                           ///< of the vehicle meanwhile
  std::shared_ptr<const LaserScan> swept;                      ///< with the sensor's motion

  /// Of an event that outlives it. The CPU time of finding landmarks in a scan is added to
  /// `perception_s`.
  static Sight of(const SensorEvent& event, const Perception& perception, double& perception_s);

  /// Cannot be used, for this reason.
  void refuse(std::string reason);
  /// Cannot be used if it is not new.
  void mustBeNewTo(const ScanClock& clock);
  /// Takes observations that cannot be used out of the set; says how many. As undoSweep(), of what
  /// can be used only.
  std::size_t dropUnusable();
  /// Takes observations to the stamp, where the vehicle is now, if they were made after it.
  void undoSweep(const VehicleState& vehicle, const CompressedEkf& filter);
};

}  // namespace hymm::core
