#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include <Eigen/Core>

#include "door_planner/barrier.h"
#include "door_planner/door_graph.h"
#include "door_planner/door_planner_config.h"
#include "door_planner/landmark_discs.h"
#include "door_planner/ltr_problem.h"
#include "hybrid_map/ltr_index.h"

namespace hymm::core {

/// Keeps doors and cost matrices of a map of LTRs that changes, and computes anew only what a
/// change concerns: what an LTR holds, how the vehicle's width carries obstacles across its sides,
/// or its shape. Turning and shifting LTRs costs nothing but new places.
class DoorMap {
 public:
  /// Counts since construction.
  struct Counts {
    std::size_t contents = 0, unchanged_contents = 0;
    std::size_t blocked = 0;   ///< LTRs whose blocked cells were found anew
    std::size_t matrices = 0;  ///< computed
  };

  /// Throws ConfigError if the configuration is unusable.
  explicit DoorMap(const DoorPlannerConfig& config);

  /// All LTRs there are, with their present corners. Those that cannot be used are left out, and
  /// returned.
  UnusableLtrs setLtrs(const std::vector<LtrView>& ltrs);

  /// All landmarks there are, whether they span LTRs or not. Costs are computed anew only where one
  /// has moved relative to an LTR near it, or is another.
  void setLandmarks(const std::vector<SolidLandmark>& landmarks);

  /// What the cells of an LTR hold now. False, and nothing changed, if there is no such LTR or an
  /// array does not fit its grid.
  bool setContent(int ltr, const LtrContent& content);

  /// Computes what is out of date, LTRs nearest to `place` first, at most `max_matrices` cost
  /// matrices. Returns how many are left, or how many LTRs and sides have to be looked at before
  /// that is known. `interrupted` is asked every hundredth of a second or so, or after an LTR that
  /// takes longer; true ends it, and the next call goes on from there.
  std::size_t prepare(const Eigen::Vector2d& place, std::size_t max_matrices,
                      const std::function<bool()>& interrupted = nullptr);

  /// What queries use; LTRs whose matrix is out of date cannot be crossed in it.
  std::shared_ptr<const DoorGraph> makeGraph();

  const Counts& counts() const { return counts_; }

 private:
  struct Region {
    LtrView view;
    Triangle triangle;
    Triangle computed;  ///< its geometry when its costs were computed
    double computed_factor = 1.0;
    std::vector<Barrier> barriers;  ///< that its cells are kept away from, in its local coordinates
    std::shared_ptr<const CellCosts> costs;     ///< null while nothing is known
    std::shared_ptr<const CellCosts> in_force;  ///< those that doors and matrix belong to
    std::shared_ptr<const CostMatrix> matrix;
  };
  struct Side {
    std::array<int, 2> ltrs{kNone, kNone};  ///< ids
    std::shared_ptr<const SideDoors> doors;
  };

  void forget(const Region& region);
  void connectSides();
  void touchShape(Region& region);
  void lookAround(const Eigen::Vector2d& low, const Eigen::Vector2d& high, double reach_m);
  void lookAround(const Region& region);
  bool isBorder(const Region& region, int side) const;
  bool hasBorder(const Region& region) const;
  std::vector<Barrier> barriersNear(const Region& region) const;
  class Questions;

  bool hasSameBarriers(const Region& region) const;
  void blockAround(int ltr);
  void block(Region& region);
  void open(const SideKey& key);
  bool findMovedBarriers(Questions& questions);
  bool findBlocked(Questions& questions);
  bool findDoors(Questions& questions);
  bool computeMatrices(const Eigen::Vector2d& place, std::size_t max_matrices,
                       Questions& questions);
  std::vector<std::pair<double, double>> stretchesOf(const Region& region,
                                                     const SideKey& key) const;
  SideDoors doorsOf(const SideKey& key, const Side& side) const;
  void computeMatrix(Region& region);
  std::vector<bool> blockedCells(const Region& region) const;
  double reach_m(const Region& region) const;
  std::shared_ptr<const DoorGraph> makeWhole() const;
  std::shared_ptr<const DoorGraph> makeByChanges() const;

  DoorPlannerConfig config_;
  std::vector<PropertyWeight> weights_;
  std::map<int, Region> regions_;
  std::map<SideKey, Side> sides_;
  LtrIndex index_;
  LandmarkDiscs discs_;
  std::set<int> to_look_;  ///< LTRs near which a landmark or a border may have moved
  std::set<int> to_block_, to_compute_;
  std::set<SideKey> to_open_;
  std::uint64_t next_door_id_ = 1;
  std::shared_ptr<const DoorGraph> graph_;  ///< as it was last made
  bool is_reshaped_ = true;                 ///< LTRs or doors since then
  std::set<int> changed_;                   ///< LTRs whose costs or matrices are others since then
  Counts counts_;
};

}  // namespace hymm::core
