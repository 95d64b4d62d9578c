#pragma once

#include <vector>

#include <Eigen/Core>

#include "hybrid_map/simplex.h"

namespace hymm::core {

/// A step from the centre of a cell to that of another.
struct CellStep {
  /// A cell that the step passes, relative to the one where it starts.
  struct Pass {
    int di = 0, dj = 0;
    double share = 0.0;  ///< of the step's length
  };
  int di = 0, dj = 0;
  double length_m = 0.0;
  std::vector<Pass> passes;  ///< in order, both ends included
};

/// Lengths in the sheared cells of an LTR, (13)-(15). Costs that depend on them alone change
/// neither when the LTR turns nor when it shifts.
class CellMetric {
 public:
  /// Takes steps until a path along them is nowhere longer than a straight one by more than the
  /// share `max_error`.
  CellMetric(const Triangle& triangle, int alpha_cells, int beta_cells, double max_error);

  /// Length [m] of a difference in units of cells: (15), whose cross term is
  /// 2 dalpha dbeta (a_x b_x + a_y b_y).
  double length(const Eigen::Vector2d& cells) const {
    return std::sqrt(cells.dot(squared_ * cells));
  }

  /// By direction, counter-clockwise over a full turn; the second half holds the opposites of the
  /// first in the same order.
  const std::vector<CellStep>& steps() const { return steps_; }

  /// Share by which the worst direction is longer along steps than straight.
  double error() const { return error_; }

 private:
  double angleBetween(const Eigen::Vector2i& u, const Eigen::Vector2i& v) const;
  void refine(const Eigen::Vector2i& u, const Eigen::Vector2i& v, double max_angle);
  void addStep(const Eigen::Vector2i& step);

  Eigen::Matrix2d squared_;  ///< of the metric, m^2 per cell^2
  std::vector<CellStep> steps_;
  double error_ = 0.0;
};

}  // namespace hymm::core
