#pragma once

#include <string>

#include "door_planner/door_planner.h"
#include "hybrid_map/hybrid_map.h"

namespace hymm::core {

/// Plans between random places of the planner's map, each time for a disc and for a car, and asks
/// the dense map itself along the paths. Returns the content of plan_queries.csv.
std::string checkQueries(const DoorPlanner& planner, const HybridMap& map, int queries);

}  // namespace hymm::core
