#pragma once

#include <cstdlib>

#include <Eigen/Core>

namespace hymm::core {

/// The cells of a unit grid that a straight line passes (in units of cells), in order and each once
/// (Amanatides and Woo, 1987). Exact but for rounding; each step leaves a cell through one side,
/// and no step leaves the box of the two ends.
struct CellWalk {
  int i, j;                             ///< of the cell where it starts
  int step_i, step_j;                   ///< 1 or -1
  int left_i, left_j;                   ///< steps to go
  double next_i, next_j, per_i, per_j;  ///< shares of the line at which it crosses sides

  CellWalk(const Eigen::Vector2d& from, const Eigen::Vector2d& to)
      : i(floorOf(from.x())), j(floorOf(from.y())) {
    const Eigen::Vector2d along = to - from;
    const int steps_i = floorOf(to.x()) - i, steps_j = floorOf(to.y()) - j;
    step_i = steps_i > 0 ? 1 : -1;
    step_j = steps_j > 0 ? 1 : -1;
    left_i = std::abs(steps_i);
    left_j = std::abs(steps_j);
    per_i = left_i > 0 ? step_i / along.x() : 0.0;
    per_j = left_j > 0 ? step_j / along.y() : 0.0;
    next_i = (i + (step_i > 0 ? 1 : 0) - from.x()) * step_i * per_i;
    next_j = (j + (step_j > 0 ? 1 : 0) - from.y()) * step_j * per_j;
  }

  /// Calls `visit()` at each cell, and `stepI()` or `stepJ()` in between. Returns how many cells.
  template <class Visitor, class StepI, class StepJ>
  int run(Visitor&& visit, StepI&& stepI, StepJ&& stepJ) {
    const int cells = left_i + left_j + 1;
    while (left_i > 0 && left_j > 0) {
      visit();
      if (next_i < next_j) {
        stepI();
        next_i += per_i;
        --left_i;
      } else {
        stepJ();
        next_j += per_j;
        --left_j;
      }
    }
    for (; left_i > 0; --left_i) {
      visit();
      stepI();
    }
    for (; left_j > 0; --left_j) {
      visit();
      stepJ();
    }
    visit();
    return cells;
  }

 private:
  /// std::floor is a call where the processor is not known to have an instruction for it.
  static int floorOf(double value) {
    const int towards_zero = static_cast<int>(value);
    return towards_zero - (value < towards_zero ? 1 : 0);
  }
};

/// Calls `visit(i, j)` for each of these cells.
template <class Visitor>
void traverseCells(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Visitor&& visit) {
  CellWalk walk(from, to);
  int i = walk.i, j = walk.j;
  walk.run([&] { visit(i, j); }, [&] { i += walk.step_i; }, [&] { j += walk.step_j; });
}

}  // namespace hymm::core
