#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "door_planner/door_graph.h"
#include "door_planner/door_planner_config.h"
#include "door_planner/footprint.h"
#include "door_planner/plan.h"

namespace hymm::test {

inline bool goesBackwards(const core::Plan& plan) {
  return std::any_of(plan.points.begin(), plan.points.end(),
                     [](const core::PlanPoint& point) { return point.is_backwards; });
}

inline double longestStep_m(const core::Plan& plan) {
  double longest = 0.0;
  for (std::size_t i = 1; i < plan.path.size(); ++i) {
    longest = std::max(longest, (plan.path[i] - plan.path[i - 1]).norm());
  }
  return longest;
}

inline bool isOccupied(const core::DoorGraph& graph, const Eigen::Vector2d& place) {
  const int ltr = graph.locate(place);
  if (ltr == core::kNone || !graph.ltr(ltr).costs) return false;
  const core::CellCosts& costs = *graph.ltr(ltr).costs;
  return costs.isOccupied(costs.grid().index(graph.ltr(ltr).triangle.toLocal(place)));
}

/// Number of points at which a disc of the vehicle's width on its axis reaches into an occupied
/// cell, asked for at places around each disc's rim and inside, less than a cell apart.
inline int touches(const core::Plan& plan, const core::DoorGraph& graph,
                   const core::PlannedVehicleConfig& vehicle) {
  constexpr double kSlack_m = 0.02;  // headings come from chords
  const core::Footprint footprint(vehicle);
  int count = 0;
  for (std::size_t i = 0; i < plan.path.size(); ++i) {
    const core::Pose2 pose{plan.path[i].x(), plan.path[i].y(), core::headingAt(plan, i)};
    bool touches = false;
    for (const double centre : footprint.centres()) {
      for (const double share : {1.0, 0.6, 0.2}) {
        const double radius = share * (0.5 * vehicle.width_m - kSlack_m);
        for (int k = 0; k < 48; ++k) {
          const double angle = 2.0 * M_PI * k / 48;
          const Eigen::Vector2d rim(centre + radius * std::cos(angle), radius * std::sin(angle));
          touches = touches || isOccupied(graph, pose * rim);
        }
      }
    }
    count += touches ? 1 : 0;
  }
  return count;
}

}  // namespace hymm::test
