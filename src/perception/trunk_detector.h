#pragma once

#include <array>
#include <optional>
#include <vector>

#include "perception/beam_view.h"
#include "perception/observation.h"
#include "perception/perception_config.h"
#include "perception/trunk_fit.h"

namespace hymm::core {

/// Finds trunks in a scan: narrow round shapes that stand in front of what is beside them.
/// Immutable.
class TrunkDetector {
 public:
  TrunkDetector(const TrunkConfig& config, const LaserNoise& noise);

  /// Appends the trunks of a scan to `observations`, in the order of the beams.
  void detect(const BeamView& beams, std::vector<Observation>& observations) const;

 private:
  /// Beams from the first to the last hit of one shape, both included.
  struct Shape {
    int first = 0;
    int last = 0;
    int hits = 0;
    double nearest_m = 0.0;
  };

  double joinLimit(const BeamView& beams, double range_m, int steps) const;
  int nextOfShape(const BeamView& beams, int hit, int direction) const;
  Shape shapeFrom(const BeamView& beams, int first, int end) const;
  std::optional<int> edgeGap(const BeamView& beams, int edge, int direction) const;
  bool mayBeTrunk(const BeamView& beams, const Shape& shape) const;
  std::optional<Observation> observe(const BeamView& beams, const Shape& shape) const;
  bool isTrunk(const TrunkEstimate& estimate, int hits) const;
  Observation toObservation(const BeamView& beams, const Shape& shape,
                            const TrunkEstimate& estimate) const;

  TrunkConfig config_;
  LaserNoise noise_;
  double tan_max_incidence_;
  std::array<double, TrunkEvidence::kMaxHits> chi_square_limits_;  ///< by degrees of freedom
};

}  // namespace hymm::core
