#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "cekf/landmark_map.h"
#include "common/config.h"
#include "common/pose2.h"

namespace hymm::core {

/// Which landmarks count as old, and as being in view.
struct OldLandmarkConfig {
  double age_s = 60.0;          ///< since the scan that put it into the map
  double range_m = 15.0;        ///< from the sensor
  double half_angle_rad = 1.3;  ///< from the sensor's x axis
  int least_observations = 10;
  double unseen_s = 2.0;  ///< after its last sighting one has not been seen lately
  /// Share of those in a part of the view that are seen; where it was less so far, the sensor does
  /// not look there, or something hides what is there, or its detector sees little.
  double seen_share = 0.7;

  void describe(ConfigSchema& schema);
};

/// Old landmarks that should be in view.
struct OldLandmarksInView {
  int expected = 0;
  int unseen = 0;  ///< of these, not seen lately

  double unseenShare() const { return expected > 0 ? static_cast<double>(unseen) / expected : 0.0; }
};

/// Counts, scan by scan, the landmarks that were in the map for long and that the sensor should see
/// from where the filter takes it to be: those in parts of its view in which such landmarks were
/// mostly seen so far. So it learns how far and how wide a sensor sees, which for detections nobody
/// knows. What hides a single landmark is not known here.
class OldLandmarkWatch {
 public:
  explicit OldLandmarkWatch(const OldLandmarkConfig& config) : config_(config) {}

  /// In order of time.
  OldLandmarksInView look(const std::vector<LandmarkEstimate>& landmarks, const Pose2& T_map_sensor,
                          double time_s);
  /// Another map, or another recording, begins.
  void clear() { parts_ = {}; }

 private:
  static constexpr std::size_t kRings = 2, kSectors = 8;
  struct Part {
    int looked = 0;
    int seen = 0;  ///< of these, lately
  };

  std::optional<std::size_t> partOf(const Eigen::Vector2d& p_sensor_landmark) const;
  bool isLookedAt(const Part& part) const;

  OldLandmarkConfig config_;
  std::array<Part, kRings * kSectors> parts_{};
};

}  // namespace hymm::core
