#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include <Eigen/Core>

namespace hymm::core {

/// Calls `visit(i, j, share)` for each cell of a unit grid that the straight line from `from` to
/// `to` (in units of cells) passes, in order, with the share of its length that lies in the cell.
/// Ends early, and returns false, where `visit` does.
template <class Visitor>
bool traverseShares(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Visitor&& visit) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const Eigen::Vector2d along = to - from;
  int i = static_cast<int>(std::floor(from.x())), j = static_cast<int>(std::floor(from.y()));
  const int last_i = static_cast<int>(std::floor(to.x()));
  const int last_j = static_cast<int>(std::floor(to.y()));
  const int step_i = last_i > i ? 1 : -1, step_j = last_j > j ? 1 : -1;
  const double per_i = i == last_i ? 0.0 : step_i / along.x();
  const double per_j = j == last_j ? 0.0 : step_j / along.y();
  double next_i = i == last_i ? kNever : ((step_i > 0 ? i + 1 : i) - from.x()) / along.x();
  double next_j = j == last_j ? kNever : ((step_j > 0 ? j + 1 : j) - from.y()) / along.y();
  double at = 0.0;
  while (i != last_i || j != last_j) {
    const double next = std::min(next_i, next_j);
    if (!visit(i, j, std::max(0.0, next - at))) return false;
    at = next;
    if (next_i < next_j) {
      i += step_i;
      next_i = i == last_i ? kNever : next_i + per_i;
    } else {
      j += step_j;
      next_j = j == last_j ? kNever : next_j + per_j;
    }
  }
  return visit(i, j, std::max(0.0, 1.0 - at));
}

}  // namespace hymm::core
