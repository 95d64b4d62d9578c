#pragma once

#include "simulation/truth.h"
#include "simulation/world.h"

namespace hymm::core {

/// Cells that a standing solid touches, over all solids and the route with some room around. Throws
/// std::invalid_argument for a resolution that is not positive.
TrueOccupancy rasterised(const World& world, double resolution_m);

}  // namespace hymm::core
