#pragma once

#include <vector>

#include <Eigen/Core>

#include "door_planner/cell_costs.h"
#include "door_planner/cell_metric.h"
#include "door_planner/cheapest_first.h"
#include "hybrid_map/simplex.h"

namespace hymm::core {

/// A path inside one LTR and its cost (9).
struct LocalPath {
  double cost = kNoPassing;
  std::vector<Triangle::Local> points;  ///< both ends included; empty if there is no path

  bool exists() const { return cost < kNoPassing; }
};

/// Cheapest paths inside one LTR: A* over its passable cells, then pulled straight where that costs
/// no more. Costs are integrals along the paths that are returned, not along cells.
class LocalSearch {
 public:
  enum class Direction { kFrom, kTo };

  /// `costs` outlives the object.
  LocalSearch(const Triangle& triangle, const CellCosts& costs, double max_metric_error);

  /// Paths from one place to others, or (kTo) from the others to it, in the order of `others`.
  std::vector<LocalPath> find(const Triangle::Local& place,
                              const std::vector<Triangle::Local>& others,
                              Direction direction = Direction::kFrom);

  /// Integral of mu along a straight line.
  double integrate(const Triangle::Local& from, const Triangle::Local& to) const;

 private:
  struct Label {
    float cost;
    int parent;
    float bound;  ///< of what is left to the nearest of those that are looked for
  };
  struct Link {
    int cell = -1;  ///< padded
    double cost = kNoPassing;
  };

  void prepare();
  void spread(const Triangle::Local& place, Direction direction,
              const std::vector<Triangle::Local>& others, const std::vector<bool>& wanted);
  void aimAt(const std::vector<Triangle::Local>& others, const std::vector<bool>& wanted);
  float boundOf(int cell) const;
  void push(float cost, int cell, int parent);
  void takeUp(const CheapestFirst::Entry& entry, Direction direction);
  const float* stepsFrom(int padded);
  int paddedIndex(int i, int j) const { return (j + pad_) * stride_ + i + pad_; }
  Triangle::Local placeOf(int padded) const;
  /// Cells that the third side cuts before their centre are passed, but no path turns in them.
  bool hasItsCentreInside(int i, int j) const;
  template <class Visitor>
  void visitNear(const Triangle::Local& place, Visitor&& visitor) const;
  double oriented(const Triangle::Local& a, const Triangle::Local& b, Direction direction) const {
    return direction == Direction::kFrom ? integrate(a, b) : integrate(b, a);
  }
  Link bestLink(const Triangle::Local& other, Direction direction) const;
  LocalPath trace(const Triangle::Local& place, const Triangle::Local& other,
                  Direction direction) const;
  LocalPath pulled(const std::vector<Triangle::Local>& points) const;

  const CellCosts& costs_;
  Eigen::Matrix2d edges_;  ///< of the triangle, m
  CellMetric metric_;
  int pad_ = 0, stride_ = 0, rows_ = 0;
  bool is_prepared_ = false;
  std::vector<int> step_offsets_;
  std::vector<float> per_metre_;  ///< by padded cell; infinite where nothing passes
  std::vector<int> cells_;        ///< number in the grid by padded cell; -1 where no path turns
  /// Costs of the steps from a padded cell but for what rises or falls, made when the cell is first
  /// taken up: where each cell's begin, or -1, and the costs, infinite where no step leads.
  std::vector<int> first_step_;
  std::vector<float> step_costs_;
  float cheapest_step_ = 0.0F;
  CheapestFirst waiting_;                 ///< padded cells by cost and bound
  std::vector<Eigen::Vector2f> targets_;  ///< in m, from the triangle's first corner
  std::vector<bool> is_end_;              ///< by padded cell
  std::size_t ends_ = 0;                  ///< not yet reached
  std::vector<Label> labels_;             ///< by padded cell
};

}  // namespace hymm::core
