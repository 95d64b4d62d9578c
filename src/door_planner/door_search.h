#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "door_planner/door_graph.h"

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
/// these. The bound h = mu_min |x - goal| / (1 + shape tolerance) is admissible and consistent, so
/// the route is the cheapest along portals. One object serves one query at a time; its memory is
/// used again.
class DoorSearch {
 public:
  /// `stop` is asked now and then; true ends the search. `admits`, if given, tells whether a place
  /// may be crossed; ways inside an LTR are taken as they are, or not at all.
  struct Options {
    std::function<bool()> stop;
    std::function<bool(const Eigen::Vector2d&)> admits;
  };

  SearchOutcome find(const DoorGraph& graph, const GraphPlace& start, const GraphPlace& goal,
                     const Options& options, DoorRoute& route);

 private:
  /// Of a portal. `parent` is a portal, or kStart.
  struct Label {
    float cost;
    float bound;  ///< h
    std::int32_t parent;
    std::uint32_t query;   ///< labels of other queries do not count
    std::int32_t through;  ///< LTR that the way to the portal runs through last
  };
  struct Entry {
    float total;
    std::int32_t portal;
    bool operator>(const Entry& other) const { return total > other.total; }
  };
  static constexpr std::int32_t kStart = -1;

  void begin(const DoorGraph& graph);
  void offer(int portal, float cost, int parent, int through);
  void expand(int portal);
  bool admits(int ltr, const std::vector<Triangle::Local>& points) const;
  bool admitsWay(int ltr, int from, int to) const;
  std::vector<Triangle::Local> wayBetween(int ltr, int from, int to) const;
  void close(int ltr, LocalSearch::Direction direction, std::vector<LocalPath>& paths) const;
  void trace(const GraphPlace& start, const GraphPlace& goal, int last, DoorRoute& route) const;

  const DoorGraph* graph_ = nullptr;
  Eigen::Vector2d goal_ = Eigen::Vector2d::Zero();
  const Options* options_ = nullptr;
  std::vector<Label> labels_;
  std::vector<Entry> queue_;
  std::uint32_t query_ = 0;
  std::vector<LocalPath> from_start_, to_goal_;  ///< by portal of the LTR of start and goal
  LocalPath direct_;
};

}  // namespace hymm::core
