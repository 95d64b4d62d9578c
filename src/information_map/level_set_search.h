#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "information_map/certificate_store.h"
#include "information_map/information_evaluator.h"
#include "information_map/information_map_config.h"
#include "information_map/landmark_watch.h"
#include "information_map/level_islands.h"
#include "information_map/level_lattice.h"

namespace hymm::core {

/// What a change of the map did to one level set.
struct LevelChange {
  double area_m2 = 0.0;  ///< now
  double gained_m2 = 0.0;
  double lost_m2 = 0.0;  ///< of what was in the set, in the coordinates of map
  /// Of that, what is out of the set even where it moved along with the landmarks around: by so
  /// much (24) does not hold.
  double lost_moving_m2 = 0.0;
  double kept_m2 = 0.0;  ///< lost, but kept by configuration
};

/// Outcome of an update.
struct LevelSetUpdate {
  std::string refused;  ///< empty, or why nothing changed
  std::size_t evaluations = 0;
  bool is_complete = true;  ///< false where max_evaluations left something for the next update
  std::vector<LevelChange> levels;  ///< by ascending value
};

/// Keeps nested level sets (22) of the achievable information along with the map, by looking only
/// where something can have changed.
///
/// Cells on a border are evaluated, those inside and outside are taken to be like their
/// surroundings (24). An evaluation holds as long as the landmarks around have neither moved
/// enough to change the set of visible ones, nor changed in covariance enough to bring the
/// information over a value (CertificateStore). Where it does not hold, the cell is evaluated
/// again, and if its level changed, so are its neighbours: a wave that ends where levels agree. The
/// same is done from samples inside the sets, and from exploration points, which climb the
/// information near landmarks that are not in the highest set (paper IV-A, IV-B).
class LevelSetSearch {
 public:
  /// Throws ConfigError if the configuration is unusable. `hides`: see InformationEvaluator.
  explicit LevelSetSearch(const InformationMapConfig& config,
                          InformationEvaluator::Occlusion hides = nullptr);

  /// The sets for a new version of the map; what is in the island of `vehicle` goes first.
  LevelSetUpdate update(std::shared_ptr<const LandmarkField> field, const Eigen::Vector2d& vehicle);

  const std::vector<double>& values() const { return values_; }
  const LevelLattice& lattice() const { return lattice_; }
  /// Of the set of `level`, 1 for the lowest value.
  const LevelIslands& islands(int level) const { return islands_[std::size_t(level - 1)]; }

 private:
  /// Cells to evaluate: those of the vehicle's island, and others.
  enum Priority { kVehicle = 0, kOthers = 1 };

  std::string reasonToRefuse(const LandmarkField& field) const;
  void fillSurroundings(const Eigen::Vector2d& vehicle);
  void fillWaiting();
  void fillBlock(const Cell& low, int edge);
  void noteChanges();
  void revokeNear(int tile, const ChangedLandmark& change);
  void sampleTiles();
  void sampleTile(int tile);
  void queueBorders(const Eigen::Vector2d& vehicle);
  void queueTile(int tile, int vehicle_island);
  void spread();
  void explore();
  std::array<Eigen::Vector2d, 5> explorationPoints(const Eigen::Vector2d& landmark) const;
  std::optional<Cell> climb(const Eigen::Vector2d& start);

  int evaluate(const Cell& cell);
  void evaluateAndSettle(const Cell& cell, Priority priority);
  bool keepsLoss(const Cell& cell, int before, int measured);
  bool holds(const Cell& cell) const;
  const Certificate& certificate(const Cell& cell) const;
  int levelOf(double information) const;
  int tileOf(const Cell& cell);
  std::size_t evaluations() const { return evaluator_.counts().evaluations; }
  bool mayEvaluate() const { return evaluations() - evaluations_before_ < budget_; }

  InformationMapConfig config_;
  std::vector<double> values_;
  double reach_m_;
  bool keeps_losses_;
  InformationEvaluator evaluator_;
  LevelLattice lattice_;
  CertificateStore certificates_;
  std::vector<LevelIslands> islands_;
  LandmarkWatch watch_;
  std::unordered_map<int, Cell> summits_;  ///< where the climb from a landmark ended, by id
  std::shared_ptr<const LandmarkField> field_;

  std::size_t budget_;
  bool was_complete_ = false;  ///< the update before
  std::vector<Cell> to_fill_;  ///< first cells of blocks; the last one is next
  // Of the update that is going on:
  std::size_t evaluations_before_ = 0;
  std::optional<LandmarkMotion> motion_;
  std::array<std::deque<Cell>, 2> queues_;  ///< by Priority
  std::vector<LevelChange> changes_;
};

}  // namespace hymm::core
