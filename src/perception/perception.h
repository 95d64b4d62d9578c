#pragma once

#include <vector>

#include "perception/laser_scan.h"
#include "perception/observation.h"
#include "perception/perception_config.h"
#include "perception/reflector_detector.h"
#include "perception/trunk_detector.h"

namespace hymm::core {

/// Finds landmarks (trunks, reflectors) in laser scans. Immutable, so one object serves any number
/// of threads.
class Perception {
 public:
  /// Throws ConfigError if the configuration is unusable.
  explicit Perception(const PerceptionConfig& config);

  /// Landmarks of a scan, by bearing. The scan has passed scanProblem(). Where both detectors find
  /// the same object it is a reflector.
  std::vector<Observation> detect(const LaserScan& scan) const;

 private:
  PerceptionConfig config_;
  TrunkDetector trunks_;
  ReflectorDetector reflectors_;
};

}  // namespace hymm::core
