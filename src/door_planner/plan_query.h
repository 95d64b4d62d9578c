#pragma once

#include <optional>
#include <string>
#include <vector>

#include "door_planner/door_graph.h"
#include "door_planner/door_planner_config.h"
#include "door_planner/door_search.h"
#include "door_planner/path_shortening.h"
#include "door_planner/plan.h"

namespace hymm::core {

/// A plan that was not made, and why.
Plan refusedPlan(PlanStatus status, const std::string& sentence);

/// One request against one graph.
class PlanQuery {
 public:
  /// All arguments outlive the object. `districts` of the graph may be null.
  PlanQuery(const DoorGraph& graph, const Districts* districts, const DoorPlannerConfig& config,
            const PlanRequest& request)
      : graph_(graph), districts_(districts), config_(config), request_(request) {}

  Plan run(DoorSearch& search);

 private:
  std::optional<Plan> check();
  bool isInformed(const Eigen::Vector2d& point) const;
  bool isInterrupted();
  GraphPlace locate(const Eigen::Vector2d& point) const;
  bool isFree(const GraphPlace& place) const;
  std::optional<GraphPlace> freeAt(const Eigen::Vector2d& point) const;
  std::optional<GraphPlace> nearestFree(const Eigen::Vector2d& point);
  std::optional<Plan> place(const std::string& what, const Eigen::Vector2d& point,
                            PlanStatus outside, PlanStatus occupied, GraphPlace& found);
  Plan stopped() const;
  Plan noWay(DoorSearch& search);
  Plan join(const DoorRoute& route);
  std::string refine(std::vector<PathPoint>& path, Plan& plan);
  void describe(const std::vector<PathPoint>& path, Plan& plan) const;

  const DoorGraph& graph_;
  const Districts* districts_;
  const DoorPlannerConfig& config_;
  const PlanRequest& request_;
  GraphPlace start_, goal_;
  PlanStatus interruption_ = PlanStatus::kOk;
};

}  // namespace hymm::core
