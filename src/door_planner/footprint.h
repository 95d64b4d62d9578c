#pragma once

#include <vector>

#include "common/pose2.h"
#include "door_planner/door_graph.h"
#include "door_planner/door_planner_config.h"

namespace hymm::core {

/// A vehicle as discs of its width in a row along its axis. Cells that are too near to something
/// occupied for such a disc are blocked, so that it is enough to ask for the cells of the centres.
/// The rectangle's corners reach beyond the outermost discs by a fifth of the width.
class Footprint {
 public:
  explicit Footprint(const PlannedVehicleConfig& vehicle);

  /// Places of the centres on the vehicle's axis, of base_link [m].
  const std::vector<double>& centres() const { return centres_; }

  /// Whether all centres lie in passable cells.
  bool isFree(const DoorGraph& graph, const Pose2& T_map_base) const;

 private:
  std::vector<double> centres_;
};

}  // namespace hymm::core
