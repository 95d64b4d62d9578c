#pragma once

#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "door_planner/door_graph.h"
#include "door_planner/place_link.h"
#include "door_planner/portal_search.h"

namespace hymm::core {

/// A place on the way from start to goal, with the LTR that the way there runs through.
struct Waypoint {
  GraphPlace place;
  int portal = kNone;  ///< where it is one
};

/// A way along doors.
struct DoorRoute {
  double cost = kNoPassing;         ///< K weighted (19)
  std::vector<int> portals;         ///< in order
  std::vector<Waypoint> waypoints;  ///< from start to goal: portals, and turns between them
  std::size_t expanded = 0;         ///< portals that the search took up
};

enum class SearchOutcome { kFound, kNoWay, kStopped };

/// A* over portals (paper, III.E): start and goal are made portals of their LTRs by searches inside
/// these. The bound h = min(K mu_min / stretch) |x - goal| is admissible and consistent, so the
/// route is the cheapest along portals. One object serves one query at a time; its memory is used
/// again.
class DoorSearch {
 public:
  /// `stop` is asked now and then; true ends the search. `admits`, if given, tells whether a place
  /// may be crossed; ways inside an LTR are taken as they are, or not at all. `districts`, of the
  /// same graph, make the search shorter and its outcome no other; not with `admits`, which their
  /// matrices know nothing of.
  struct Options {
    std::function<bool()> stop;
    Admits admits;
    const Districts* districts = nullptr;
  };

  SearchOutcome find(const DoorGraph& graph, const GraphPlace& start, const GraphPlace& goal,
                     const Options& options, DoorRoute& route);

 private:
  using Step = PortalSearch::Step;

  PortalSearch::Scope scopeOf(const DoorGraph& graph, const GraphPlace& start,
                              const GraphPlace& goal, const Options& options) const;
  std::vector<Step> stepsAlong(const PortalSearch::Scope& scope, DoorRoute& route);
  std::vector<Step> stepsInside(const PortalSearch::Scope& scope, int district, int from, int to);

  PortalSearch portals_;
};

}  // namespace hymm::core
