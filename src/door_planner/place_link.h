#pragma once

#include <functional>
#include <vector>

#include "door_planner/door_graph.h"
#include "door_planner/local_search.h"

namespace hymm::core {

/// Whether a place may be crossed; may be empty.
using Admits = std::function<bool(const Eigen::Vector2d&)>;

/// Whether all of a path inside an LTR may be crossed: asked every quarter of a metre.
bool admitsAll(const DoorGraph& graph, int ltr, const std::vector<Triangle::Local>& points,
               const Admits& admits);

/// A start or goal as one more portal of its LTR (paper, III.E): the ways between it and the
/// others, found by a search there.
struct PlaceLink {
  std::vector<LocalPath> ways;  ///< by portal of the LTR
  LocalPath direct;             ///< to the other place, if that lies in the same LTR

  /// From the place (kFrom) or to it (kTo); `other`, if given, lies in the same LTR.
  PlaceLink(const DoorGraph& graph, const GraphPlace& place, LocalSearch::Direction direction,
            const Admits& admits, const GraphPlace* other = nullptr);

 private:
  void close(const DoorGraph& graph, int ltr, LocalSearch::Direction direction);
};

}  // namespace hymm::core
