#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "common/random.h"
#include "relocaliser/density_map.h"
#include "relocaliser/local_map.h"
#include "relocaliser/particle_set.h"

namespace hymm::core {

/// Headings from `centre_rad - half_width_rad` to `centre_rad + half_width_rad`.
struct HeadingInterval {
  double centre_rad = 0.0;
  double half_width_rad = kPi;  ///< pi or more: all headings
};

/// The vehicle's poses (38) from which `point` is seen where a landmark stands: for each heading
/// one place, which makes a helix of the pose space. What errors (39) do to the place is the
/// landmark's covariance and that of the point.
Pose2 poseOnHelix(const Eigen::Vector2d& landmark, const Eigen::Vector2d& p_base_point,
                  double heading_rad);

/// What to sample from.
struct HelicalRegions {
  const std::vector<LocalLandmark>& landmarks;
  const std::vector<ObservedPoint>& points;
  HeadingInterval headings;
  std::optional<PosePrior> prior;  ///< local frame; nothing: the vehicle may be anywhere
  double prior_deviations = 3.0;   ///< beyond these no particle is placed
};

/// Poses from the helical regions around every pair of an observation and a landmark, of each pair
/// equally many before what the prior excludes: at most `count`. They are weighted so that they
/// stand for prior times likelihood of all observations: `density` is of the same landmarks and
/// points. The proposal's own density is, up to a constant, the sum over the observations of the
/// landmarks' density where they fall, so that is what weights are divided by.
ParticleSet sampleHelicalRegions(const HelicalRegions& regions, const DensityMap& density,
                                 std::size_t count, RandomGenerator& generator);

}  // namespace hymm::core
