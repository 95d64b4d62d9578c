#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "door_planner/door_graph.h"
#include "door_planner/place_link.h"

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
/// these. The bound h = min(K mu_min / stretch) |x - goal| is admissible and consistent, so
/// the route is the cheapest along portals. Portals of a side are taken up together: the costs of
/// the ways from them lie side by side. One object serves one query at a time; its memory is used
/// again.
class DoorSearch {
 public:
  /// `stop` is asked now and then; true ends the search. `admits`, if given, tells whether a place
  /// may be crossed; ways inside an LTR are taken as they are, or not at all.
  struct Options {
    std::function<bool()> stop;
    Admits admits;
  };

  SearchOutcome find(const DoorGraph& graph, const GraphPlace& start, const GraphPlace& goal,
                     const Options& options, DoorRoute& route);

 private:
  struct Label {
    float cost;
    float bound;     ///< h
    float expanded;  ///< cost at which it was last taken up
    /// Twice the portal, or kStart, from which the way comes, plus the end, of the side's LTRs,
    /// that it came through.
    std::int32_t parent;
    std::size_t end() const { return std::size_t(parent & 1); }
    int from() const { return parent >> 1; }
    bool isPending() const { return cost < expanded; }
    float total() const { return cost + bound; }
  };
  /// Labels of sides that another query left behind do not count.
  struct SideState {
    float queued;  ///< total with which it waits
    std::uint32_t query = 0;
  };
  struct Entry {
    float total;
    std::int32_t side;
  };
  static constexpr std::int32_t kStart = -1;

  void begin(const DoorGraph& graph, const GraphPlace& start, const GraphPlace& goal);
  void open(int side);
  void enqueue(int side, float total);
  void offerStart(const GraphPlace& start, const PlaceLink& from);
  bool next(Entry& entry);
  void takeUp(const Entry& entry, const GraphPlace& goal, const PlaceLink& to, DoorRoute& route);
  void expand(int side, int portal);
  void trace(const GraphPlace& start, const GraphPlace& goal, const PlaceLink& from,
             const PlaceLink& to, DoorRoute& route) const;

  const DoorGraph* graph_ = nullptr;
  const Options* options_ = nullptr;
  Eigen::Vector2f goal_ = Eigen::Vector2f::Zero();
  float least_ = 0.0F;
  float limit_ = 0.0F;             ///< of the cheapest way to the goal so far
  int last_ = kStart;              ///< its last portal
  std::vector<Label> labels_;      ///< by portal
  std::vector<SideState> states_;  ///< by side
  /// By total cost. What is taken up too early is taken up again when it turns out to be cheaper,
  /// so the order within a bucket does not matter for the outcome.
  std::vector<std::vector<Entry>> buckets_;
  std::size_t first_bucket_ = 0;
  float lowest_ = 0.0F, buckets_per_cost_ = 1.0F, together_ = 0.0F;
  std::uint32_t query_ = 0;
};

}  // namespace hymm::core
