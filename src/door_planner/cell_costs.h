#pragma once

#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "door_planner/door_planner_config.h"
#include "door_planner/ltr_view.h"
#include "door_planner/share_traversal.h"
#include "hybrid_map/triangular_grid.h"

namespace hymm::core {

constexpr double kNoPassing = std::numeric_limits<double>::infinity();

/// The grid of an LTR with given numbers of cells along its sides.
TriangularGrid gridOf(int alpha_cells, int beta_cells);

/// What a metre costs in each cell of an LTR, mu of (9)-(11). Three kinds of cells: occupied ones,
/// ones that are blocked because something occupied is too near for the vehicle's width, and
/// passable ones.
class CellCosts {
 public:
  /// Nothing known.
  CellCosts(const PathCostConfig& config, const TriangularGrid& grid);
  /// Throws std::invalid_argument if an array does not have one value a cell.
  CellCosts(const PathCostConfig& config, const std::vector<PropertyWeight>& weights,
            const TriangularGrid& grid, const LtrContent& content);

  const TriangularGrid& grid() const { return grid_; }

  bool isOccupied(int cell) const { return value(cell) == -std::numeric_limits<float>::infinity(); }
  bool isPassable(int cell) const { return value(cell) > 0.0F; }
  /// Of a metre in a passable cell.
  float perMetre(int cell) const { return value(cell); }
  /// Infinite if nothing is passable.
  double leastPerMetre() const { return least_; }
  bool isUniform() const { return values_.empty() && !isDirected(); }
  /// Whether going one way can cost more than going back.
  bool isDirected() const { return is_directed_; }
  /// What going from one cell to another costs in addition, because a layer rises or falls there.
  float passing(int from, int to) const { return passing(*this, from, *this, to); }
  /// The same across the side of two LTRs, whose costs come from the same configuration.
  static float passing(const CellCosts& one, int from, const CellCosts& other, int to);

  /// Local coordinates of the centres of occupied cells that have a free one beside them, or lie on
  /// a border of the LTR: what the others keep away from, they keep away from too.
  const std::vector<Eigen::Vector2f>& obstacles() const { return obstacles_; }

  /// Makes those cells blocked, and no others, that are marked.
  void setBlocked(const std::vector<bool>& blocked);
  std::vector<bool> blocked() const;

  /// Integral of mu along a straight line inside the LTR, `length_m` long; infinite if it passes an
  /// occupied or blocked cell.
  double integrate(const Triangle::Local& from, const Triangle::Local& to, double length_m) const;

  std::size_t bytes() const;
  bool operator==(const CellCosts& other) const {
    return values_ == other.values_ && uniform_ == other.uniform_ && directed_ == other.directed_;
  }

 private:
  /// A layer whose rise or fall costs something; without values where the LTR has none of it.
  struct DirectedLayer {
    float rise = 0.0F, fall = 0.0F;  ///< of one unit
    std::vector<float> values;       ///< NaN where they are not known: going there and back is free
    bool operator==(const DirectedLayer& other) const;
  };

  float value(int cell) const { return values_.empty() ? uniform_ : values_[std::size_t(cell)]; }
  void addProperty(const PropertyWeight& weight, const std::vector<float>& values);
  void addDirected(const PropertyWeight& weight, const LtrContent& content);
  void finish();
  void findObstacles();

  TriangularGrid grid_;
  /// Passable: cost of a metre; blocked: its negative; occupied: minus infinity. Empty if all are
  /// `uniform_`.
  std::vector<float> values_;
  float uniform_ = 1.0F;
  std::vector<DirectedLayer> directed_;  ///< by the configuration's order
  bool is_directed_ = false;
  std::vector<Eigen::Vector2f> obstacles_;
  double least_ = kNoPassing;
};

}  // namespace hymm::core
