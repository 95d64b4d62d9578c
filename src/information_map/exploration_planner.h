#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "common/pose2.h"
#include "information_map/information_evaluator.h"
#include "information_map/information_map_config.h"
#include "information_map/level_islands.h"
#include "information_map/level_lattice.h"
#include "vehicle/motion_model.h"

namespace hymm::core {

/// A place at the border of an island, and what to expect of going there.
struct ExplorationGoal {
  Pose2 T_map_base;                  ///< heading as the way arrives
  std::vector<Eigen::Vector2d> way;  ///< inside the island, from the vehicle [m]
  double way_m = 0.0;
  double position_deviation_m = 0.0;   ///< largest predicted on the way
  double heading_deviation_rad = 0.0;  ///< largest predicted on the way
  double new_area_m2 = 0.0;            ///< outside of the level set, within range of the goal
  int joins_island = -1;               ///< another island within range of the goal
};

/// What a suggestion is asked for.
struct ExplorationRequest {
  Pose2 T_map_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< (x [m], y [m], yaw [rad]), map axes
  int level = 1;                                         ///< the set that the way stays inside
};

/// `problem` is empty, or says why there is no goal.
struct ExplorationAnswer {
  std::string problem;
  std::vector<ExplorationGoal> goals;  ///< best first
  int candidates = 0;                  ///< at the border, before the limits on deviations
};

/// Suggests where to explore such that the vehicle stays well localised on the way (paper IV,
/// VI.B): goals at the border of the vehicle's island that are reached inside it.
///
/// Deviations are predicted with the vehicle's noise and the observations to be expected at each
/// place. Observations at neighbouring places share the errors of the map, so they are fused by
/// covariance intersection: the prediction is never too small on that account. Goals are ranked by
/// the area that comes into range for the first time (a whole island counts if it is reached) over
/// the length of the way and the range.
class ExplorationPlanner {
 public:
  using IsFree = std::function<bool(const Eigen::Vector2d& place)>;

  /// References outlive the object. `is_free`: whether the vehicle can be at a place; empty for
  /// everywhere. `hides`: see InformationEvaluator. Throws ConfigError if the vehicle's geometry is
  /// unusable.
  ExplorationPlanner(const InformationMapConfig& config, const VehicleConfig& vehicle,
                     const LevelLattice& lattice, const LevelIslands& islands,
                     const LandmarkField& field, IsFree is_free = nullptr,
                     InformationEvaluator::Occlusion hides = nullptr);

  ExplorationAnswer suggest(const ExplorationRequest& request);

 private:
  struct Reached {
    double way_m = 0.0;
    Cell from;
  };

  std::optional<Cell> startCell(const ExplorationRequest& request) const;
  void findWays(const Cell& start);
  std::vector<Cell> candidates() const;
  std::vector<Eigen::Vector2d> wayTo(const Cell& goal) const;
  void predict(const ExplorationRequest& request, ExplorationGoal& goal);
  Eigen::Matrix3d drive(Pose2 pose, double length_m, Eigen::Matrix3d P) const;
  Eigen::Matrix3d informationAt(const Pose2& T_map_base);
  Eigen::Matrix3d fuse(const Eigen::Matrix3d& covariance, const Eigen::Matrix3d& information) const;
  void judge(ExplorationGoal& goal) const;
  bool exceedsLimits(const ExplorationGoal& goal) const;
  void keepBest(std::vector<ExplorationGoal>& goals) const;
  bool isInside(const Cell& cell) const { return lattice_.level(cell) >= level_; }
  static std::uint64_t keyOf(const Cell& cell) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(cell.x)) << 32U |
           static_cast<std::uint32_t>(cell.y);
  }

  InformationMapConfig config_;
  Pose2 T_base_sensor_;
  MotionModel motion_;
  const LevelLattice& lattice_;
  const LevelIslands& islands_;
  const LandmarkField& field_;
  IsFree is_free_;
  InformationEvaluator evaluator_;
  int level_ = 1;
  int island_ = -1;
  std::unordered_map<std::uint64_t, Reached> reached_;
};

/// Information on the pose of base_link from information on the pose of a sensor on it.
Eigen::Matrix3d informationOnBase(const Eigen::Matrix3d& on_sensor, const Pose2& T_map_base,
                                  const Pose2& T_base_sensor);

}  // namespace hymm::core
