#pragma once

#include <vector>

#include "perception/laser_scan.h"
#include "perception/observation.h"
#include "perception/perception_config.h"

namespace hymm::core {

/// Finds landmarks (trunks, reflectors) in laser scans. Immutable.
class Perception {
 public:
  /// Throws ConfigError if the configuration is unusable.
  explicit Perception(const PerceptionConfig& config);

  /// Landmarks of a scan, by bearing. The scan has passed scanProblem().
  std::vector<Observation> detect(const LaserScan& scan) const;

 private:
  PerceptionConfig config_;
};

}  // namespace hymm::core
