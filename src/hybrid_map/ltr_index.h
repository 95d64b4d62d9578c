#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "hybrid_map/cell_traversal.h"

namespace hymm::core {

/// Finds LTRs by place: a hash of square cells over map, each with the LTRs whose bounding box
/// touches it. An LTR that moves within its cells costs nothing.
class LtrIndex {
 public:
  explicit LtrIndex(double cell_m) : cells_per_m_(1.0 / cell_m) {}

  /// Adds an LTR, or moves it, to the box from `low` to `high` [m].
  void place(int ltr, const Eigen::Vector2d& low, const Eigen::Vector2d& high);
  void remove(int ltr);

  /// Calls `visit(ltr)` once for each LTR whose cells and those of the box have one in common.
  template <class Visitor>
  void visit(const Eigen::Vector2d& low, const Eigen::Vector2d& high, Visitor&& visitor) const {
    const Cells box = cellsOf(low, high);
    for (std::int32_t x = box.x0; x <= box.x1; ++x) {
      for (std::int32_t y = box.y0; y <= box.y1; ++y) {
        const auto cell = content_.find(keyOf(x, y));
        if (cell == content_.end()) continue;
        for (const int ltr : cell->second) {
          // Of the cells that both have, the least one tells.
          const Cells& other = cells_[std::size_t(ltr)];
          if (x == std::max(box.x0, other.x0) && y == std::max(box.y0, other.y0)) visitor(ltr);
        }
      }
    }
  }

  /// Calls `visit(ltr)` for the LTRs in each cell that the straight line passes; one that is in
  /// many of these cells is visited as often.
  template <class Visitor>
  void visitAlong(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Visitor&& visitor) const {
    const auto visitCell = [&](std::int32_t x, std::int32_t y) {
      const auto cell = content_.find(keyOf(x, y));
      if (cell == content_.end()) return;
      for (const int ltr : cell->second) visitor(ltr);
    };
    traverseCells(from * cells_per_m_, to * cells_per_m_, visitCell);
  }

  template <class Archive>
  void describeState(Archive& archive) {
    archive(content_, cells_);
  }
  /// Whether all LTRs in it have numbers below `end`, and are as many at most.
  bool isBelow(int end) const;

 private:
  /// A rectangle of cells, ends included; empty by default.
  struct Cells {
    std::int32_t x0 = 0, y0 = 0, x1 = -1, y1 = -1;

    template <class Archive>
    void describeState(Archive& archive) {
      archive(x0, y0, x1, y1);
    }
    bool operator==(const Cells& o) const {
      return x0 == o.x0 && y0 == o.y0 && x1 == o.x1 && y1 == o.y1;
    }
  };

  std::int32_t cellOf(double coordinate) const {
    return static_cast<std::int32_t>(std::floor(coordinate * cells_per_m_));
  }
  Cells cellsOf(const Eigen::Vector2d& low, const Eigen::Vector2d& high) const {
    return {cellOf(low.x()), cellOf(low.y()), cellOf(high.x()), cellOf(high.y())};
  }
  static std::uint64_t keyOf(std::int32_t x, std::int32_t y) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)) << 32U |
           static_cast<std::uint32_t>(y);
  }

  double cells_per_m_;
  std::unordered_map<std::uint64_t, std::vector<int>> content_;
  std::vector<Cells> cells_;  ///< by LTR
};

}  // namespace hymm::core
