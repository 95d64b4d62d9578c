#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "cekf/landmark_map.h"
#include "common/pose2.h"
#include "information_map/exploration_planner.h"
#include "information_map/information_evaluator.h"
#include "information_map/information_map_config.h"
#include "information_map/level_quadtree.h"
#include "information_map/level_set_search.h"
#include "vehicle/vehicle_config.h"

namespace hymm::core {

/// One level set (22), as a quadtree.
struct LevelSet {
  double value = 0.0;  ///< beta [1/m^2]
  double area_m2 = 0.0;
  std::vector<LevelLeaf> leaves;
  std::vector<Island> islands;       ///< largest first
  std::vector<JoinedIsland> joined;  ///< by the last change of the map
  int vehicle_island = -1;           ///< id, -1 where the vehicle is outside
};

/// All level sets of one version of the map, by ascending value.
struct LevelSets {
  std::uint64_t map_version = 0;       ///< whose coordinates the leaves are in
  std::uint64_t computed_version = 0;  ///< that the sets were computed for
  double time_s = 0.0;                 ///< of that version
  double resolution_m = 0.0;
  std::vector<LevelSet> sets;
};

/// Where the vehicle can stay well localised (paper IV): the achievable information of any pose,
/// and its level sets, kept up to date with the landmark map. The engine of the node
/// `information_map`. Deterministic; not thread-safe.
///
///   InformationMap information(config, vehicle);
///   information.apply(landmarks, T_map_base);        // after each change of the map
///   information.levelSets();                         // quadtrees with islands
///   information.evaluate(T_map_base);                // of one pose
///   information.suggestExploration(request);         // goals at the border
class InformationMap {
 public:
  /// Counts since construction.
  struct Counts {
    std::size_t maps = 0, refused_maps = 0;
    std::size_t evaluations = 0;
    std::size_t unfinished_updates = 0;  ///< ended by max_evaluations
    std::size_t refused_landmarks = 0;   ///< not finite, or with an unusable covariance
    std::size_t refused_pairs = 0;
  };

  /// Throws ConfigError if the configuration is unusable.
  InformationMap(const InformationMapConfig& config, const VehicleConfig& vehicle);
  ~InformationMap();
  InformationMap(InformationMap&&) noexcept;
  InformationMap& operator=(InformationMap&&) noexcept;

  /// A new version of the map, with the vehicle in it. An older one than the last is refused.
  LevelSetUpdate apply(const LandmarkMap& map, const Pose2& T_map_base);

  /// The dense map as it is now, in the coordinates of (about) the landmarks' last version: ways to
  /// suggested goals go around what is occupied, and with dense_map.occlusion it hides landmarks,
  /// for level sets from the next apply() on.
  void setDenseMap(const OccupancyImage& image);
  bool hasDenseMap() const;

  /// An empty map, without a dense one.
  void reset();

  /// As of the last accepted map.
  LevelSets levelSets() const;

  /// The same sets in the coordinates of another version of the map, until they are computed for
  /// it: each leaf goes with the landmarks around it. Its size stays.
  LevelSets levelSetsMovedTo(const LandmarkMap& newer) const;

  /// What the sensor learns at least about the pose of base_link at `T_map_base` by looking once.
  AchievableInformation evaluate(const Pose2& T_map_base) const;

  /// The same for any heading, as the configuration judges places: `value` as level sets have it.
  /// About the pose of the sensor.
  AchievableInformation evaluatePlace(const Eigen::Vector2d& p_map_sensor) const;

  /// Goals at the border of the vehicle's island. Without a dense map, ways know of no obstacles.
  ExplorationAnswer suggestExploration(const ExplorationRequest& request) const;

  /// Level (1 for the lowest) of the highest value that is at most `value`, 0 if there is none.
  int levelOf(double value) const;

  std::uint64_t mapVersion() const;
  const InformationMapConfig& config() const;
  const LevelSetSearch& search() const;
  const Counts& counts() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hymm::core
