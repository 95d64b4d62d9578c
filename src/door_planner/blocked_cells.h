#pragma once

#include <vector>

#include <Eigen/Core>

#include "door_planner/barrier.h"
#include "door_planner/cell_costs.h"
#include "hybrid_map/simplex.h"

namespace hymm::core {

/// Cells of an LTR in which the vehicle's centre would be too near to something occupied: half its
/// width from every point of an occupied cell, whichever LTR that lies in.
class BlockedCells {
 public:
  /// `triangle` and `grid` outlive the object.
  BlockedCells(const Triangle& triangle, const TriangularGrid& grid, double half_width_m);

  /// From what is occupied in an LTR, this one or another.
  void keepAwayFrom(const Triangle& triangle, const CellCosts& costs);
  /// From a landmark or a border, in map; by `slack_m` more, so that it may move that much.
  void keepAwayFrom(const Barrier& barrier, double slack_m);
  void free(int cell) { blocked_[std::size_t(cell)] = false; }

  const std::vector<bool>& cells() const { return blocked_; }

 private:
  void block(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double radius_m);

  const Triangle& triangle_;
  const TriangularGrid& grid_;
  double half_width_m_;
  Eigen::Matrix2d cell_edges_, inverse_;  ///< of a cell, m
  std::vector<bool> blocked_;
};

}  // namespace hymm::core
