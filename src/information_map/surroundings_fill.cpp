#include "information_map/surroundings_fill.h"

#include <algorithm>
#include <array>
#include <utility>

namespace hymm::core {
namespace {

using Eigen::Vector2d;

/// Edge of the blocks that the fill starts with [cells].
constexpr int kBlockBits = 3;
constexpr int kBlock = 1 << kBlockBits;

/// A quadtree from above: a block whose corners and centre agree is filled, another one is split.
void fillBlock(LevelCells& cells, const Cell& low, int edge) {
  const int last = edge - 1, middle = edge / 2;
  const std::array<Cell, 5> probes = {{{low.x, low.y},
                                       {low.x + last, low.y},
                                       {low.x, low.y + last},
                                       {low.x + last, low.y + last},
                                       {low.x + middle, low.y + middle}}};
  int least = cells.lattice().levels(), most = 0;
  for (const Cell& probe : probes) {
    const int level =
        cells.holds(probe) ? cells.levelOf(cells.certificate(probe).value) : cells.evaluate(probe);
    cells.lattice().set(probe, level);
    least = std::min(least, level);
    most = std::max(most, level);
  }
  if (edge <= 2) return;
  if (least < most) {
    const int half = edge / 2;
    for (const auto& [dx, dy] : {std::pair{0, 0}, {half, 0}, {0, half}, {half, half}}) {
      fillBlock(cells, {low.x + dx, low.y + dy}, half);
    }
    return;
  }
  for (int y = 0; y < edge; ++y) {
    for (int x = 0; x < edge; ++x) cells.lattice().set({low.x + x, low.y + y}, least);
  }
}

}  // namespace

/// Lists the blocks that are within reach of a landmark, those near the vehicle last.
SurroundingsFill::SurroundingsFill(const LandmarkField& field, const LevelLattice& lattice,
                                   double reach_m, const Vector2d& vehicle) {
  for (int i = 0; i < field.size(); ++i) {
    const Cell low = lattice.cellAt(field.position(i) - Vector2d::Constant(reach_m));
    const Cell high = lattice.cellAt(field.position(i) + Vector2d::Constant(reach_m));
    for (std::int32_t y = low.y >> kBlockBits; y <= high.y >> kBlockBits; ++y) {
      for (std::int32_t x = low.x >> kBlockBits; x <= high.x >> kBlockBits; ++x) {
        waiting_.push_back({x * kBlock, y * kBlock});
      }
    }
  }
  const auto distance = [&](const Cell& cell) {
    return (lattice.centre({cell.x + kBlock / 2, cell.y + kBlock / 2}) - vehicle).squaredNorm();
  };
  std::sort(waiting_.begin(), waiting_.end(), [&](const Cell& a, const Cell& b) {
    const double to_a = distance(a), to_b = distance(b);
    if (to_a != to_b) return to_a > to_b;
    return a.y != b.y ? a.y < b.y : a.x < b.x;
  });
  waiting_.erase(std::unique(waiting_.begin(), waiting_.end()), waiting_.end());
}

void SurroundingsFill::goOn(LevelCells& cells) {
  while (!waiting_.empty() && cells.mayEvaluate()) {
    fillBlock(cells, waiting_.back(), kBlock);
    waiting_.pop_back();
  }
}

}  // namespace hymm::core
