#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "information_map/changed_looks.h"
#include "information_map/exploration_points.h"
#include "information_map/information_evaluator.h"
#include "information_map/information_map_config.h"
#include "information_map/landmark_watch.h"
#include "information_map/level_cells.h"
#include "information_map/level_islands.h"
#include "information_map/surroundings_fill.h"

namespace hymm::core {

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

  /// Squares around places of the dense map block a look now and did not, or the other way round;
  /// the next update takes account of it. See ChangedLooks.
  void noteChangedLooks(const std::vector<Eigen::Vector2d>& places, double half_m,
                        double clearance_m);

  const std::vector<double>& values() const { return cells_.values(); }
  const LevelLattice& lattice() const { return cells_.lattice(); }
  /// Of the set of `level`, 1 for the lowest value.
  const LevelIslands& islands(int level) const { return islands_[std::size_t(level - 1)]; }

 private:
  std::string reasonToRefuse(const LandmarkField& field) const;
  void noteChanges();
  void revokeNear(int tile, const ChangedLandmark& change);
  void sampleTiles();
  void sampleTile(int tile);
  void queueBorders(const Eigen::Vector2d& vehicle);
  void queueTile(int tile, int vehicle_island);
  CertificateStore& certificates() { return cells_.certificates(); }

  double range_m_, reach_m_, max_cells_;
  LevelCells cells_;
  std::vector<LevelIslands> islands_;
  LandmarkWatch watch_;
  SurroundingsFill fill_;
  ChangedLooks changed_looks_;
  ExplorationPoints exploration_points_;
  std::shared_ptr<const LandmarkField> field_;
  bool was_complete_ = false;  ///< the update before
};

}  // namespace hymm::core
