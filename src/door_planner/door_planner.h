#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include <Eigen/Core>

#include "door_planner/districts.h"
#include "door_planner/door_graph.h"
#include "door_planner/door_map.h"
#include "door_planner/door_planner_config.h"
#include "door_planner/door_search.h"
#include "door_planner/plan.h"
#include "door_planner/weighted_maps.h"

namespace hymm::core {

/// Plans paths over LTRs by their doors (paper, III.E). The engine of the node `door_planner`.
///
///   DoorPlanner planner(config);
///   planner.setLtrs(views);                // where LTRs are, and who neighbours whom
///   planner.setLandmarks(landmarks);       // which no vehicle passes
///   planner.setContent(id, content);       // what their cells hold
///   planner.prepare(vehicle);              // doors and cost matrices of what changed
///   planner.plan(request);
///
/// One thread changes the map; plan() and the functions on plans may be called from any thread at
/// the same time, and use the map as it was when it was last prepared.
class DoorPlanner {
 public:
  /// Throws ConfigError if the configuration is unusable.
  explicit DoorPlanner(const DoorPlannerConfig& config);
  ~DoorPlanner();

  /// See DoorMap.
  UnusableLtrs setLtrs(const std::vector<LtrView>& ltrs);
  void setLandmarks(const std::vector<SolidLandmark>& landmarks);
  bool setContent(int ltr, const LtrContent& content) {
    return setContent(ltr, std::make_shared<const LtrContent>(content));
  }
  /// Keeps what the pointer leads to, for requests that bring weights of their own.
  bool setContent(int ltr, std::shared_ptr<const LtrContent> content);

  /// Brings queries up to date. Returns the number of LTRs whose matrices are still to be computed,
  /// because there were more than `max_matrices`: until they are, nothing crosses them.
  std::size_t prepare(const Eigen::Vector2d& place,
                      std::size_t max_matrices = static_cast<std::size_t>(-1));

  /// Brings districts up to date, which make long queries fast and change no answer: until they
  /// are, queries do without them. Computes at most `max_matrices`; returns how many are left.
  std::size_t prepareDistricts(std::size_t max_matrices = static_cast<std::size_t>(-1));

  /// The first request with weights of its own computes all costs anew, which takes as long as the
  /// first prepare() did.
  Plan plan(const PlanRequest& request) const;

  /// The first point of a path that can no longer be reached from the one before it, because what
  /// lies between is occupied now; nothing if the path is free. Points in map, now.
  std::optional<std::size_t> findBlocked(const std::vector<Eigen::Vector2d>& path) const;

  std::shared_ptr<const DoorGraph> graph() const;
  /// Of that graph; null while there are none.
  std::shared_ptr<const Districts> districts() const;
  const DoorMap::Counts& counts() const { return map_.counts(); }
  const DoorPlannerConfig& config() const { return config_; }

 private:
  struct Searches;

  DoorPlannerConfig config_;
  DoorMap map_;
  mutable std::mutex graph_mutex_;
  std::shared_ptr<const DoorGraph> graph_;
  std::shared_ptr<const Districts> districts_;  ///< of the graph, or of one before it
  PortalSearch district_search_;
  std::unique_ptr<Searches> searches_;  ///< memory of queries, used again
  mutable WeightedMaps weighted_maps_;
};

}  // namespace hymm::core
