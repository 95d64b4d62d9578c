#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "cekf/cekf_slam.h"
#include "perception/laser_scan.h"
#include "perception/perception_config.h"

namespace hymm::core {

/// Tells at the end of a run what it looked for in vain, so that dead reckoning does not pass for a
/// map, and what may be the reason.
class SightReport {
 public:
  explicit SightReport(const PerceptionConfig& config) : config_(config) {}

  void take(const LaserScan& scan);

  /// Sentences; none where there is nothing to tell. `landmarks`: of the map at the end.
  std::vector<std::string> sentences(const CekfSlam::Counts& counts, std::size_t landmarks) const;

 private:
  std::string reflectorSentence() const;

  PerceptionConfig config_;
  std::size_t scans_ = 0;
  std::size_t scans_with_intensities_ = 0;
  float largest_intensity_ = 0.0F;  ///< of beams that met something
};

}  // namespace hymm::core
