#pragma once

#include <vector>

#include "relocaliser/local_map.h"

namespace hymm::core {

/// Local maps that together cover a whole map, for a vehicle that may be anywhere in it: each of
/// the landmarks around one of them, so that from any place where landmarks are in view one of the
/// maps holds most of what is seen. A landmark that stands in the middle of one is in the middle of
/// no other; neighbours overlap. `spacing_m`: between two middles, at least. Empty if the map has
/// fewer than two landmarks that know each other.
std::vector<LocalMap> makeNeighbourhoods(const JointLandmarks& landmarks, double spacing_m,
                                         const LocalMapConfig& config);

}  // namespace hymm::core
