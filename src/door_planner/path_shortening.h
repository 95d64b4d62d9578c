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
  bool dropPoints(std::vector<PathPoint>& path, std::vector<double>& costs) const;
  bool movePoints(std::vector<PathPoint>& path, std::vector<double>& costs, double step_m) const;

  const DoorGraph& graph_;
  const Allows& allows_;
};

}  // namespace hymm::core
