#pragma once

#include <limits>
#include <string>

#include <Eigen/Core>

#include "common/config.h"
#include "common/pose2.h"
#include "hybrid_map/hybrid_map.h"
#include "perception/laser_scan.h"

namespace hymm::core {

struct ScanMatcherConfig {
  double search_radius_m = 1.0;
  double search_heading_rad = 0.1;
  double range_m = 30.0;
  int min_known_beams = 20;
  double min_score = 0.4;

  void describe(ConfigSchema& schema);
};

/// Where a scan fits the map best. `matched` false: nothing else counts but `reason`.
struct ScanMatch {
  bool matched = false;
  std::string reason;
  Pose2 T_map_laser;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< x, y, yaw in map; m, rad
  /// Share of what the scan hits, where the map knows, that lies on obstacles of the map; 0 to 1.
  double score = 0.0;
  int known_beams = 0;  ///< hits at places that the map knows
};

/// How well a scan and the map agree (paper, V). What the map does not know has no say.
struct ScanAgreement {
  /// Correlation of what the scan says (occupied where beams end, free along them) and what the map
  /// says there: 1 if they agree, 0 if they have nothing to do with each other; NaN where less than
  /// `min_known_beams` end at places that the map knows.
  double correlation = std::numeric_limits<double>::quiet_NaN();
  int known_beams = 0;       ///< that end where the map knows something
  double known_share = 0.0;  ///< of all beams that end within range
};

/// Holds scans against the occupancy that the LTRs have stored. Scans that are older than the map's
/// last correction are compared with the map as it is now.
class ScanMatcher {
 public:
  /// Throws ConfigError if the configuration is unusable.
  explicit ScanMatcher(const ScanMatcherConfig& config);

  /// Searches all poses around `guess` within the configured window, at first in steps of a cell
  /// (a correlative search: Olson, 2009), then in between.
  ScanMatch match(const HybridMap& map, const LaserScan& scan, const Pose2& guess) const;

  /// At a pose. To be asked before the scan is written, else the map has learned the answer.
  ScanAgreement agreement(const HybridMap& map, const LaserScan& scan,
                          const Pose2& T_map_laser) const;

 private:
  ScanMatcherConfig config_;
};

}  // namespace hymm::core
