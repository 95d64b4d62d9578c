#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "datasets/reading_count.h"
#include "perception/laser_scan.h"
#include "vehicle/motion_input.h"

namespace hymm::core {

/// Ranges from here on mean "no return" in ACFR's recordings: their laser was set to 80 m, and
/// codes what lies beyond as 81.83 m to 81.91 m.
inline constexpr double kAcfrNoReturn_m = 80.0;

/// Sensors of ACFR's recordings, by the numbers that their event order uses.
enum class AcfrSensor { kGps = 1, kMotion = 2, kLaser = 3 };

/// A GPS position in the recording's local frame; not finite where the receiver had none.
struct LocalFix {
  double time_s = 0.0;
  double east_m = 0.0;
  double north_m = 0.0;
};

/// A recording of ACFR's utility car, whatever form it was published in. Scans follow ROS:
/// bearings counter-clockwise from straight ahead, no return is +inf. Stamps are the recording's,
/// but a time 0, which ROS keeps for "not set", becomes 1 ns.
struct AcfrRecording {
  struct Event {
    AcfrSensor sensor;
    std::size_t index;  ///< into scans, motion or fixes
  };

  std::string form;  ///< for people, for instance "Victoria Park, ASCII"
  std::vector<LaserScan> scans;
  std::vector<AckermannInput> motion;
  std::vector<LocalFix> fixes;
  std::vector<Event> events;  ///< in the recording's own order
  std::vector<ReadingCount> counts;

  double timeOf(const Event& event) const;
};

/// Reads a recording, given as one of
///   - the Victoria Park ASCII archive or its folder (LASER.txt, DRS.txt, GPS.txt,
///     Sensors_manager.txt),
///   - the MATLAB files of Victoria Park together (aa3_lsr2, aa3_dr and, if there is GPS,
///     aa3_gpsx), or the folder that holds them,
///   - one MATLAB file of the car-park form (data_set.mat), or the folder that holds it.
/// MATLAB files are told apart by their variables, not by their names. Throws InputError.
AcfrRecording readAcfr(const std::vector<std::filesystem::path>& inputs);

}  // namespace hymm::core
