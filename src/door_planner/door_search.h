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
/// these. The bound h = min(K mu_min / stretch) |x - goal| is admissible and consistent, so
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
  /// Of a portal.
  struct Label {
    float cost = 0.0F;
    float bound = 0.0F;                     ///< h
    std::int32_t parent = 0;                ///< twice the portal, or kStart, plus the end (below)
    std::uint32_t query = 0;                ///< labels of other queries do not count
    int end() const { return parent & 1; }  ///< of the portal's LTRs the one that leads to it
    int from() const { return parent >> 1; }
  };
  struct Entry {
    float cost;
    std::int32_t portal;
  };
  static constexpr std::int32_t kStart = -1;

  void begin(const DoorGraph& graph);
  void open(int portal);
  void offer(int portal, float cost, int parent, int through);
  bool next(float limit, Entry& entry);
  void expand(int portal);
  bool admits(int ltr, const std::vector<Triangle::Local>& points) const;
  bool admitsWay(int ltr, int from, int to) const;
  std::vector<Triangle::Local> wayBetween(int ltr, int from, int to) const;
  void close(int ltr, LocalSearch::Direction direction, std::vector<LocalPath>& paths) const;
  void trace(const GraphPlace& start, const GraphPlace& goal, int last, DoorRoute& route) const;

  const DoorGraph* graph_ = nullptr;
  Eigen::Vector2f goal_ = Eigen::Vector2f::Zero();
  float least_ = 0.0F;
  const Options* options_ = nullptr;
  std::vector<Label> labels_;
  /// By total cost in steps of bucket_. What is taken up too early is taken up again when it turns
  /// out to be cheaper, so the order within a bucket does not matter for the outcome.
  std::vector<std::vector<Entry>> buckets_;
  std::size_t first_bucket_ = 0;
  float lowest_ = 0.0F, buckets_per_cost_ = 1.0F;
  std::uint32_t query_ = 0;
  std::vector<LocalPath> from_start_, to_goal_;  ///< by portal of the LTR of start and goal
  LocalPath direct_;
};

}  // namespace hymm::core
