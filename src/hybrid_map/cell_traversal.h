#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include <Eigen/Core>

namespace hymm::core {

/// The cells of a unit grid that a straight line passes (in units of cells), in order and each
/// once. Exact but for rounding, of 2^-36 of a cell for each that it passes; each step leaves a
/// cell through one side, and no step leaves the box of the two ends.
///
/// In each column (or row, whichever it passes more of) a line passes one cell or two. Which ones
/// is told by the place at which it leaves the column, and that is carried along as an integer: no
/// step waits for a comparison of the one before, as in the walk of Amanatides and Woo (1987),
/// which passes the same cells.
class CellWalk {
 public:
  CellWalk(const Eigen::Vector2d& from, const Eigen::Vector2d& to)
      : start_i(floorOf(from.x())), start_j(floorOf(from.y())) {
    const Eigen::Vector2d along = to - from;
    is_along_i = std::abs(along.x()) >= std::abs(along.y());
    const int end_i = floorOf(to.x()) - start_i, end_j = floorOf(to.y()) - start_j;
    const double in_i = from.x() - start_i, in_j = from.y() - start_j;
    if (is_along_i) {
      begin(end_i, end_j, in_i, in_j, along.x() != 0.0 ? along.y() / along.x() : 0.0);
    } else {
      begin(end_j, end_i, in_j, in_i, along.x() / along.y());
    }
  }

  int start_i, start_j;  ///< the cell where it starts
  bool is_along_i;       ///< whether its longer axis is that of i

  /// Calls `visit(along, aside, other)` for each column, counted from the start: its place on the
  /// longer axis, and on the other axis the cell in which the line enters it and that in which it
  /// leaves, which are neighbours or the same. Returns the number of cells.
  template <class Visit>
  int run(Visit&& visit) const {
    int along = 0, aside = 0;
    std::int64_t at_exit = at_exit_;
    for (int left = std::abs(end_along_); left > 0; --left) {
      const int next = static_cast<int>(at_exit >> kFractionBits);
      visit(along, aside, next);
      along += step_along_;
      aside = next;
      at_exit += slope_;
    }
    const int left = end_aside_ - aside;
    const int step = left > 0 ? 1 : -1;
    visit(along, aside, left != 0 ? aside + step : aside);
    // Rounding may leave more than one cell for the last column.
    for (int other = aside + 2 * step; step * (end_aside_ - other) >= 0; other += step) {
      visit(along, other, other);
    }
    return std::abs(end_along_) + std::abs(end_aside_) + 1;
  }

 private:
  static constexpr int kFractionBits = 36;

  /// Ends are cells counted from the start, `in_…` places in the first cell, `slope` at most 1.
  void begin(int end_along, int end_aside, double in_along, double in_aside, double slope) {
    end_along_ = end_along;
    end_aside_ = end_aside;
    step_along_ = end_along > 0 ? 1 : -1;
    const double to_exit = end_along > 0 ? 1.0 - in_along : -in_along;
    at_exit_ = fixedPoint(in_aside + to_exit * slope);
    slope_ = step_along_ * fixedPoint(slope);
    stayBeforeEnd();
  }

  /// Where rounding would leave the box of the two ends, the line is bent into it.
  void stayBeforeEnd() {
    const std::int64_t columns = std::abs(end_along_) - 1;
    if (columns < 0) return;
    const std::int64_t low = std::int64_t{std::min(0, end_aside_)} * kOne;
    const std::int64_t high = std::int64_t{std::max(0, end_aside_)} * kOne + kOne - 1;
    at_exit_ = std::clamp(at_exit_, low, high);
    if (columns == 0) return;
    const std::int64_t last = at_exit_ + columns * slope_;
    if (last > high) slope_ = (high - at_exit_) / columns;
    if (last < low) slope_ = (low - at_exit_) / columns;
  }

  static constexpr std::int64_t kOne = std::int64_t{1} << kFractionBits;
  static std::int64_t fixedPoint(double value) {
    return static_cast<std::int64_t>(value * static_cast<double>(kOne));
  }

  /// std::floor is a call where the processor is not known to have an instruction for it.
  static int floorOf(double value) {
    const int towards_zero = static_cast<int>(value);
    return towards_zero - (value < towards_zero ? 1 : 0);
  }

  int end_along_, end_aside_, step_along_;
  std::int64_t at_exit_;  ///< where the line leaves its first column
  std::int64_t slope_;    ///< by which that grows from column to column
};

/// Calls `visit(i, j)` for each of these cells.
template <class Visitor>
void traverseCells(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Visitor&& visitor) {
  const CellWalk walk(from, to);
  const int i = walk.start_i, j = walk.start_j;
  if (walk.is_along_i) {
    walk.run([&](int along, int aside, int other) {
      visitor(i + along, j + aside);
      if (other != aside) visitor(i + along, j + other);
    });
  } else {
    walk.run([&](int along, int aside, int other) {
      visitor(i + aside, j + along);
      if (other != aside) visitor(i + other, j + along);
    });
  }
}

}  // namespace hymm::core
