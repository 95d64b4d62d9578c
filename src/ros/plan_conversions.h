#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include <hymm/LevelSet.h>
#include <nav_msgs/Path.h>
#include <visualization_msgs/MarkerArray.h>

#include "door_planner/door_graph.h"
#include "door_planner/plan.h"

namespace hymm {

/// Poses along the points, each heading for the next one, or, where `points` say that this is
/// driven to backwards, away from it.
nav_msgs::Path pathMessage(const std::vector<Eigen::Vector2d>& path, const std_msgs::Header& header,
                           const std::vector<core::PlanPoint>& points);

/// Doors as lines, portals as points, and lines between the doors of an LTR by what a metre costs
/// there, from green to red: the namespaces `doors`, `portals` and `costs`.
visualization_msgs::MarkerArray doorMarkers(const core::DoorGraph& graph,
                                            const std_msgs::Header& header);

/// Whether places lie in a level set.
class InformedPlaces {
 public:
  explicit InformedPlaces(const LevelSet& message);

  double value() const { return value_; }
  bool contains(const Eigen::Vector2d& place) const;

 private:
  struct Leaf {
    double x, y, half;
  };
  double value_, bucket_m_ = 1.0;
  /// Leaves by the buckets that they touch.
  std::unordered_map<std::uint64_t, std::vector<Leaf>> buckets_;
};

}  // namespace hymm
