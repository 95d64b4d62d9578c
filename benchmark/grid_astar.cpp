#include "benchmark/grid_astar.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>

namespace hymm::benchmarks {

GridAStar::GridAStar(int cells, double resolution_m)
    : cells_(cells),
      resolution_m_(resolution_m),
      blocked_(std::size_t(cells) * std::size_t(cells), 0),
      labels_(blocked_.size()) {
  // A border of blocked cells spares the search the checks.
  for (int i = 0; i < cells; ++i) {
    for (const int edge : {0, cells - 1}) {
      block(i, edge);
      block(edge, i);
    }
  }
}

double GridAStar::find(const Eigen::Vector2d& start, const Eigen::Vector2d& goal) {
  const Eigen::Vector2i from = (start / resolution_m_).cast<int>();
  const Eigen::Vector2i to = (goal / resolution_m_).cast<int>();
  const auto goal_index = static_cast<std::uint32_t>(indexOf(to.x(), to.y()));
  constexpr float kDiagonal = 1.41421356F;
  const std::array<std::pair<int, float>, 8> steps = {{{1, 1.0F},
                                                       {-1, 1.0F},
                                                       {cells_, 1.0F},
                                                       {-cells_, 1.0F},
                                                       {cells_ + 1, kDiagonal},
                                                       {cells_ - 1, kDiagonal},
                                                       {-cells_ + 1, kDiagonal},
                                                       {-cells_ - 1, kDiagonal}}};
  const auto bound = [&](std::uint32_t index) {
    const int dx = std::abs(static_cast<int>(index) % cells_ - to.x());
    const int dy = std::abs(static_cast<int>(index) / cells_ - to.y());
    return static_cast<float>(std::max(dx, dy)) +
           (kDiagonal - 1.0F) * static_cast<float>(std::min(dx, dy));
  };
  ++query_;
  queue_.clear();
  const auto offer = [&](std::uint32_t index, float cost) {
    Label& label = labels_[index];
    if (label.query == query_ && cost >= label.cost) return;
    label = {cost, query_};
    queue_.emplace_back(cost + bound(index), index);
    std::push_heap(queue_.begin(), queue_.end(), std::greater<>());
  };
  offer(static_cast<std::uint32_t>(indexOf(from.x(), from.y())), 0.0F);
  while (!queue_.empty()) {
    std::pop_heap(queue_.begin(), queue_.end(), std::greater<>());
    const auto [total, index] = queue_.back();
    queue_.pop_back();
    const float cost = labels_[index].cost;
    if (index == goal_index) return static_cast<double>(cost) * resolution_m_;
    if (total > cost + bound(index) + 1e-3F) continue;
    for (const auto& [offset, length] : steps) {
      const auto next = static_cast<std::uint32_t>(static_cast<std::int64_t>(index) + offset);
      if (blocked_[next] == 0) offer(next, cost + length);
    }
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace hymm::benchmarks
