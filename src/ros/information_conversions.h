#pragma once

#include <string>
#include <vector>

#include <hymm/ExplorationGoal.h>
#include <hymm/LevelSet.h>
#include <visualization_msgs/MarkerArray.h>

#include "information_map/information_map.h"

/// Level sets and exploration goals as messages and markers.
namespace hymm {

/// The message of one of the sets.
LevelSet toMessage(const core::LevelSets& sets, const core::LevelSet& set, bool complete,
                   const std::string& frame_id);

/// Value, area and leaves of a set.
core::LevelSet fromMessage(const LevelSet& message);

ExplorationGoal toMessage(const core::ExplorationGoal& goal);

/// The borders of the sets, a colour for each value (namespace `border`), and the islands' ids
/// (namespace `island`).
visualization_msgs::MarkerArray islandMarkers(const core::LevelSets& sets,
                                              const std::string& frame_id);

}  // namespace hymm
