#pragma once

#include <cmath>
#include <cstdlib>
#include <limits>

#include <Eigen/Core>

namespace hymm::core {

/// Calls `visit(i, j)` for each cell of a unit grid that the straight line from `from` to `to` (in
/// units of cells) passes, in order and each once, and `visitLast(i, j)` for the cell in which it
/// ends. Exact but for rounding; each step leaves a cell through one side.
template <class Visitor, class LastVisitor>
void traverseCells(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Visitor&& visit,
                   LastVisitor&& visitLast) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const Eigen::Vector2d along = to - from;
  int i = static_cast<int>(std::floor(from.x())), j = static_cast<int>(std::floor(from.y()));
  const int last_i = static_cast<int>(std::floor(to.x()));
  const int last_j = static_cast<int>(std::floor(to.y()));
  const int step_i = last_i > i ? 1 : -1, step_j = last_j > j ? 1 : -1;
  // Share of the line at which it crosses the next side of either direction.
  double next_i = i == last_i ? kNever : ((step_i > 0 ? i + 1 : i) - from.x()) / along.x();
  double next_j = j == last_j ? kNever : ((step_j > 0 ? j + 1 : j) - from.y()) / along.y();
  const double per_i = i == last_i ? 0.0 : step_i / along.x();
  const double per_j = j == last_j ? 0.0 : step_j / along.y();
  for (int steps = std::abs(last_i - i) + std::abs(last_j - j); steps > 0; --steps) {
    visit(i, j);
    if (next_i < next_j) {
      i += step_i;
      next_i = i == last_i ? kNever : next_i + per_i;
    } else {
      j += step_j;
      next_j = j == last_j ? kNever : next_j + per_j;
    }
  }
  visitLast(i, j);
}

}  // namespace hymm::core
