#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "door_planner/door_graph.h"

namespace hymm::core {

/// A point of a path in map, with an LTR that contains it.
struct PathPoint {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  int ltr = kNone;
};

/// Leaves out points where a straight line is free and costs no more (K weighted), and moves points
/// along the sides that they lie on or near where that makes the path cheaper. `allows`, if given,
/// must hold at points along a straight line for it to be taken.
class PathShortening {
 public:
  using Allows = std::function<bool(const Eigen::Vector2d&)>;

  /// `graph` and `allows` outlive the object.
  PathShortening(const DoorGraph& graph, const Allows& allows) : graph_(graph), allows_(allows) {}

  /// Returns the K weighted cost of the path that is left.
  double shorten(std::vector<PathPoint>& path) const;

 private:
  double cost(const PathPoint& from, const PathPoint& to) const;
  /// A path with the costs between its points, and whether there is a reason to try a point again:
  /// neither it nor those beside it have changed since it was last tried in vain.
  struct Draft {
    std::vector<PathPoint> path;
    std::vector<double> costs;
    std::vector<char> stale;
  };
  bool dropPoints(Draft& draft) const;
  bool movePoints(Draft& draft, double step_m) const;
  bool movePoint(Draft& draft, std::size_t i, double step_m) const;

  const DoorGraph& graph_;
  const Allows& allows_;
};

}  // namespace hymm::core
