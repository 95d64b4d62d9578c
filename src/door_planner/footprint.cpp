#include "door_planner/footprint.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {

Footprint::Footprint(const PlannedVehicleConfig& vehicle) {
  const double radius = 0.5 * vehicle.width_m;
  const double back = -vehicle.rear_overhang_m + radius;
  const double front = vehicle.length_m - vehicle.rear_overhang_m - radius;
  if (front <= back) {
    centres_.push_back(0.5 * (front + back));
    return;
  }
  // A radius apart, the discs leave out a seventh of it at the sides, between two of them.
  const int parts = static_cast<int>(std::ceil((front - back) / radius));
  for (int i = 0; i <= parts; ++i) centres_.push_back(back + (front - back) * i / parts);
}

bool Footprint::isFree(const DoorGraph& graph, const Pose2& T_map_base) const {
  const Eigen::Vector2d along(std::cos(T_map_base.yaw_rad), std::sin(T_map_base.yaw_rad));
  int ltr = kNone;
  return std::all_of(centres_.begin(), centres_.end(), [&](double centre) {
    const Eigen::Vector2d place = T_map_base.position() + centre * along;
    if (ltr == kNone || !graph.ltr(ltr).triangle.contains(place)) ltr = graph.locate(place);
    return ltr != kNone && graph.isPassable(ltr, graph.ltr(ltr).triangle.toLocal(place));
  });
}

}  // namespace hymm::core
