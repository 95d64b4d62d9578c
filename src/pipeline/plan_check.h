#pragma once

#include <string>
#include <vector>

#include "door_planner/door_planner.h"
#include "hybrid_map/hybrid_map.h"
#include "hybrid_map/ltr_index.h"

namespace hymm::core {

/// What stands in the way of a vehicle whether an LTR covers it or not: landmarks as discs, and the
/// centres of occupied cells that wait for an LTR, outside of all of them.
class StandingObjects {
 public:
  StandingObjects(const HybridMap& map, const std::vector<LandmarkEstimate>& landmarks,
                  const DoorPlannerConfig& config);

  /// From a place to the nearest, less than 0 inside a landmark; kFar_m if none is nearer.
  double distance_m(const Eigen::Vector2d& place) const;
  static constexpr double kFar_m = 5.0;

 private:
  void add(const Eigen::Vector2d& place, double radius_m);

  struct Disc {
    Eigen::Vector2d place;
    double radius_m;
  };
  std::vector<Disc> discs_;
  LtrIndex index_;
};

/// Plans between random places of the planner's map, each time for a disc and for a car, and asks
/// the dense map itself, the landmarks and the cells that wait for an LTR along the paths. Returns
/// the content of plan_queries.csv.
std::string checkQueries(const DoorPlanner& planner, const HybridMap& map,
                         const LandmarkMap& landmarks, int queries);

}  // namespace hymm::core
