#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "information_map/certificate_store.h"
#include "information_map/information_evaluator.h"
#include "information_map/information_map_config.h"
#include "information_map/landmark_watch.h"
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

/// The cells of the level sets with the evaluations that they rest on: evaluates a cell, certifies
/// the evaluation, gives the cell its level, and lets the neighbours follow where that changed.
/// Counts what an update spends and what it does to the sets.
class LevelCells {
 public:
  /// Cells to evaluate: those of the vehicle's island, and others.
  enum Priority { kVehicle = 0, kOthers = 1 };

  /// Throws ConfigError if the configuration is unusable. `hides`: see InformationEvaluator.
  LevelCells(const InformationMapConfig& config, InformationEvaluator::Occlusion hides);

  /// An update begins, from one version of the map (null at first) to another.
  void begin(std::shared_ptr<const LandmarkField> before, std::shared_ptr<const LandmarkField> now);
  /// It ends; what waits in the queues is forgotten.
  void end();

  /// Whether max_evaluations leaves an evaluation to this update.
  bool mayEvaluate() const { return evaluations() < budget_; }
  std::size_t evaluations() const {  ///< by this update
    return evaluator_.counts().evaluations - evaluations_before_;
  }
  /// By this update, by ascending value.
  const std::vector<LevelChange>& changes() const { return changes_; }

  const std::vector<double>& values() const { return values_; }
  LevelLattice& lattice() { return lattice_; }
  const LevelLattice& lattice() const { return lattice_; }
  CertificateStore& certificates() { return certificates_; }
  const LandmarkField& field() const { return *field_; }

  /// How many of the values an information reaches.
  int levelOf(double information) const;
  int tileOf(const Cell& cell);
  bool holds(const Cell& cell) const;
  /// Of a cell that was evaluated, or whose tile has been made.
  const Certificate& certificate(const Cell& cell) const;

  /// Evaluates i(X) at a cell's centre, certifies it, and returns its level; the cell keeps its.
  int evaluate(const Cell& cell);
  /// What was evaluated does not hold any more.
  void revoke(const Cell& cell);

  /// Evaluates a cell and gives it the level measured, or what the policy on losses makes of it.
  /// Where its level changed, neighbours of other levels are queued.
  void settle(const Cell& cell, Priority priority);

  void queue(const Cell& cell, Priority priority) { queues_[priority].push_back(cell); }
  /// Settles what is queued, until nothing is, or the evaluations run out.
  void spread();

 private:
  bool keepsLoss(const Cell& cell, int before, int measured);

  std::vector<double> values_;
  bool keeps_losses_;
  InformationEvaluator evaluator_;
  LevelLattice lattice_;
  CertificateStore certificates_;
  std::shared_ptr<const LandmarkField> field_;
  std::size_t budget_;
  // Of the update that is going on:
  std::size_t evaluations_before_ = 0;
  double range_m_;
  std::shared_ptr<const LandmarkField> field_before_;
  std::optional<LandmarkMotion> motion_;
  std::array<std::deque<Cell>, 2> queues_;  ///< by Priority
  std::vector<LevelChange> changes_;
};

}  // namespace hymm::core
