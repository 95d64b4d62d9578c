#include "information_map/level_lattice.h"

#include <algorithm>

namespace hymm::core {

void LevelLattice::set(const Cell& cell, int level) {
  int tile = tileOf(cell);
  if (tile < 0) {
    if (level == 0) return;
    tile = makeTileOf(cell);
  }
  std::uint8_t& held = tiles_[std::size_t(tile)].levels[std::size_t(indexInTile(cell))];
  for (int l = held + 1; l <= level; ++l) ++cells_reaching_[std::size_t(l)];
  for (int l = level + 1; l <= held; ++l) --cells_reaching_[std::size_t(l)];
  held = static_cast<std::uint8_t>(level);
}

int LevelLattice::makeTileOf(const Cell& cell) {
  const std::int32_t x = cell.x >> kTileBits, y = cell.y >> kTileBits;
  const auto [found, is_new] = tile_of_key_.try_emplace(keyOf(x, y), tileCount());
  if (is_new) {
    tiles_.emplace_back();
    tiles_.back().x = x;
    tiles_.back().y = y;
  }
  return found->second;
}

bool LevelLattice::isBorder(int tile, int index_in_tile) const {
  const auto& levels = tiles_[std::size_t(tile)].levels;
  const int x = index_in_tile & (kTileEdge - 1), y = index_in_tile >> kTileBits;
  const int level = levels[std::size_t(index_in_tile)];
  if (x > 0 && x < kTileEdge - 1 && y > 0 && y < kTileEdge - 1) {
    return levels[std::size_t(index_in_tile - 1)] != level ||
           levels[std::size_t(index_in_tile + 1)] != level ||
           levels[std::size_t(index_in_tile - kTileEdge)] != level ||
           levels[std::size_t(index_in_tile + kTileEdge)] != level;
  }
  const Cell cell = cellOf(tile, index_in_tile);
  return std::any_of(kNeighbours.begin(), kNeighbours.end(), [&](const Cell& step) {
    return this->level({cell.x + step.x, cell.y + step.y}) != level;
  });
}

double intersectionOverUnion(const LevelLattice& a, const LevelLattice& b, int level) {
  std::size_t both = 0;
  for (int tile = 0; tile < a.tileCount(); ++tile) {
    for (int i = 0; i < LevelLattice::kTileCells; ++i) {
      if (a.tile(tile).levels[std::size_t(i)] < level) continue;
      if (b.level(a.cellOf(tile, i)) >= level) ++both;
    }
  }
  const std::size_t either = a.cellsReaching(level) + b.cellsReaching(level) - both;
  return either == 0 ? 1.0 : static_cast<double>(both) / static_cast<double>(either);
}

}  // namespace hymm::core
