#pragma once

#include <vector>

#include "perception/beam_view.h"
#include "perception/observation.h"
#include "perception/perception_config.h"

namespace hymm::core {

/// Finds reflecting poles in a scan: few neighbouring bright beams at one range. Immutable.
class ReflectorDetector {
 public:
  ReflectorDetector(const ReflectorConfig& config, const LaserNoise& noise);

  /// Appends the reflectors of a scan to `observations`, in the order of the beams. A scan without
  /// intensities has none.
  void detect(const BeamView& beams, std::vector<Observation>& observations) const;

 private:
  /// Bright beams side by side.
  struct Cluster {
    int first = 0;
    int last = 0;
    double range_sum_m = 0.0;
    double nearest_m = 0.0;
    double farthest_m = 0.0;
    int hits() const { return last - first + 1; }
  };

  bool bright(const BeamView& beams, int index) const;
  Cluster clusterFrom(const BeamView& beams, int first, int end) const;
  bool isReflector(const BeamView& beams, const Cluster& cluster) const;
  Observation toObservation(const BeamView& beams, const Cluster& cluster) const;

  ReflectorConfig config_;
  LaserNoise noise_;
};

}  // namespace hymm::core
