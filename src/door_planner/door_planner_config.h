#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/config.h"

namespace hymm::core {

/// How much of a property a metre costs: k_s of (11).
struct PropertyWeight {
  enum class Kind {
    kPerMetre,   ///< times the property's value
    kClimb,      ///< each unit that the property rises costs this; falling costs nothing
    kOneWay,     ///< each unit that it falls costs this; rising costs nothing
    kForbidden,  ///< where the value is at least `weight`, nothing passes
  };
  std::string property;
  Kind kind = Kind::kPerMetre;
  double weight = 0.0;

  bool isDirected() const { return kind == Kind::kClimb || kind == Kind::kOneWay; }
  /// Of a property "LAYER.A>B" the names "LAYER.A" and "LAYER.B": cells of category A count as 0,
  /// those of B as 1, others as unknown.
  std::optional<std::pair<std::string, std::string>> categories() const;
};

/// What a metre costs (11). Free and known ground without further properties costs `distance`.
struct PathCostConfig {
  /// What a metre costs lies between these, or sums of costs would lose their digits or overflow.
  static constexpr double kCheapest = 1e-6, kDearest = 1e9;

  double distance = 1.0;
  double occupancy = 2.0;
  double occupied_probability = 0.6;
  double probability_step = 0.1;
  double unknown = 3.0;
  bool unknown_is_occupied = false;
  std::string properties;

  void describe(ConfigSchema& schema);

  /// `properties` taken apart; adds a sentence to `problems` for each that cannot be used.
  std::vector<PropertyWeight> weights(std::vector<std::string>& problems) const;

  /// These costs with what `text` names in place of what they say: entries as in `properties`, and
  /// "distance WEIGHT", "occupancy WEIGHT", "unknown WEIGHT".
  PathCostConfig with(const std::string& text, std::vector<std::string>& problems) const;
};

struct PlannedVehicleConfig {
  double width_m = 1.9;
  double length_m = 4.0;
  double rear_overhang_m = 0.9;
  double turning_radius_m = 5.0;
  bool can_reverse = true;

  void describe(ConfigSchema& schema);
};

/// How paths are made passable for a car.
struct RefinementConfig {
  bool enabled = true;
  int iterations = 2000;
  double step_m = 0.25;
  double direction_change_m = 5.0;
  int seed = 1;

  void describe(ConfigSchema& schema);
};

/// Parameters of the door planner, as the node `door_planner` documents them.
struct DoorPlannerConfig {
  PlannedVehicleConfig vehicle;
  PathCostConfig cost;
  RefinementConfig refinement;
  double portal_spacing_m = 4.0;
  double district_m = 100.0;
  double max_metric_error = 0.02;
  double shape_tolerance = 0.01;
  double landmark_diameter_m = 0.5;
  bool outside_is_occupied = true;
  double tolerance_m = 1.0;
  double time_limit_s = 1.0;
  std::string goal;
  int check_queries = 0;

  void describe(ConfigSchema& schema);

  /// `goal` in map [m]; nothing if it is empty or not two numbers.
  std::optional<Eigen::Vector2d> goalPlace() const;

  /// Everything that makes the configuration unusable, one sentence each.
  std::vector<std::string> problems() const;
};

}  // namespace hymm::core
