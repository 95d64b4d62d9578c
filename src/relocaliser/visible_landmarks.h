#pragma once

#include <vector>

#include "relocaliser/density_map.h"
#include "relocaliser/local_map.h"
#include "relocaliser/particle_set.h"

namespace hymm::core {

/// The reduced local map (A.3): those landmarks that one of `points` may be an observation of, for
/// some particle, by the worst case of the landmarks' uncertainty.
std::vector<LocalLandmark> findVisibleLandmarks(const ParticleSet& particles,
                                                const std::vector<ObservedPoint>& points,
                                                const std::vector<LocalLandmark>& landmarks);

}  // namespace hymm::core
