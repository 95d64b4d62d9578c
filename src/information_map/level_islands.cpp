#include "information_map/level_islands.h"

#include <algorithm>
#include <map>
#include <utility>

namespace hymm::core {
namespace {

constexpr int kEdge = LevelLattice::kTileEdge;

}  // namespace

int LevelIslands::rootOf(int node) {
  while (parents_[std::size_t(node)] != node) {
    int& parent = parents_[std::size_t(node)];
    parent = parents_[std::size_t(parent)];
    node = parent;
  }
  return node;
}

void LevelIslands::unite(int a, int b) {
  a = rootOf(a);
  b = rootOf(b);
  if (a != b) parents_[std::size_t(std::max(a, b))] = std::min(a, b);
}

/// Joins each cell of the set to the one on its left and the one below, within the tile.
void LevelIslands::labelTile(const LevelLattice& lattice, int tile) {
  const auto& levels = lattice.tile(tile).levels;
  TileLabels& nodes = nodes_[std::size_t(tile)];
  for (int i = 0; i < LevelLattice::kTileCells; ++i) {
    int& node = nodes[std::size_t(i)];
    node = -1;
    if (levels[std::size_t(i)] < level_) continue;
    if (i % kEdge != 0) node = nodes[std::size_t(i - 1)];
    const int below = i >= kEdge ? nodes[std::size_t(i - kEdge)] : -1;
    if (node < 0) {
      node = below;
    } else if (below >= 0 && below != node) {
      unite(node, below);
    }
    if (node < 0) {
      node = static_cast<int>(parents_.size());
      parents_.push_back(node);
    }
  }
}

void LevelIslands::update(const LevelLattice& lattice) {
  const auto tiles = std::size_t(lattice.tileCount());
  TileLabels none;
  none.fill(-1);
  ids_.resize(tiles, none);
  nodes_.resize(tiles, none);
  parents_.clear();
  for (int tile = 0; tile < lattice.tileCount(); ++tile) labelTile(lattice, tile);
  for (int tile = 0; tile < lattice.tileCount(); ++tile) connectTile(lattice, tile);

  islands_.clear();
  std::vector<int> island_of_node(parents_.size(), -1);
  for (int tile = 0; tile < lattice.tileCount(); ++tile) {
    for (int i = 0; i < LevelLattice::kTileCells; ++i) {
      const int node = nodes_[std::size_t(tile)][std::size_t(i)];
      if (node < 0) continue;
      const int root = rootOf(node);
      int& island = island_of_node[std::size_t(root)];
      if (island < 0) {
        island = static_cast<int>(islands_.size());
        islands_.push_back({-1, 0, lattice.cellOf(tile, i)});
      }
      island_of_node[std::size_t(node)] = island;
      ++islands_[std::size_t(island)].cells;
    }
  }
  inheritIds(countCommonCells(island_of_node));
  writeIds(island_of_node);
  std::stable_sort(islands_.begin(), islands_.end(),
                   [](const Island& a, const Island& b) { return a.cells > b.cells; });
}

/// Unites what meets across the right and the upper side of a tile.
void LevelIslands::connectTile(const LevelLattice& lattice, int tile) {
  const LevelLattice::Tile& here = lattice.tile(tile);
  const int right = lattice.tileOf({(here.x + 1) * kEdge, here.y * kEdge});
  const int above = lattice.tileOf({here.x * kEdge, (here.y + 1) * kEdge});
  const TileLabels& nodes = nodes_[std::size_t(tile)];
  for (int i = 0; i < kEdge; ++i) {
    const int last = nodes[std::size_t(i * kEdge + kEdge - 1)];
    const int top = nodes[std::size_t((kEdge - 1) * kEdge + i)];
    const int to_right = right < 0 ? -1 : nodes_[std::size_t(right)][std::size_t(i * kEdge)];
    const int to_above = above < 0 ? -1 : nodes_[std::size_t(above)][std::size_t(i)];
    if (last >= 0 && to_right >= 0) unite(last, to_right);
    if (top >= 0 && to_above >= 0) unite(top, to_above);
  }
}

/// Pairs of an old and a new island that have cells in common, most cells first.
std::vector<LevelIslands::CommonCells> LevelIslands::countCommonCells(
    const std::vector<int>& island_of_node) const {
  std::map<std::pair<int, int>, std::size_t> common;  // (old id, island) -> cells
  for (std::size_t tile = 0; tile < nodes_.size(); ++tile) {
    std::pair<int, int> last{-1, -1};
    std::size_t* count = nullptr;
    for (std::size_t i = 0; i < std::size_t(LevelLattice::kTileCells); ++i) {
      const int node = nodes_[tile][i], old = ids_[tile][i];
      if (node < 0 || old < 0) continue;
      const std::pair<int, int> key{old, island_of_node[std::size_t(node)]};
      if (count == nullptr || key != last) {
        count = &common[key];
        last = key;
      }
      ++*count;
    }
  }
  std::vector<CommonCells> pairs;
  for (const auto& [key, cells] : common) pairs.push_back({key.first, key.second, cells});
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const CommonCells& a, const CommonCells& b) { return a.cells > b.cells; });
  return pairs;
}

/// Gives each island the id of the old one that it has most cells of, if that has not more of its
/// own in another.
void LevelIslands::inheritIds(const std::vector<CommonCells>& pairs) {
  std::map<int, int> heir;  // old id -> island that took it
  for (const auto& [old, island, cells] : pairs) {
    if (islands_[std::size_t(island)].id >= 0 || heir.count(old) != 0) continue;
    islands_[std::size_t(island)].id = old;
    heir[old] = island;
  }
  for (Island& island : islands_) {
    if (island.id < 0) island.id = next_id_++;
  }
  joined_.clear();
  for (const auto& [old, island, cells] : pairs) {
    if (heir.count(old) != 0) continue;
    joined_.push_back({old, islands_[std::size_t(island)].id});
    heir[old] = island;
  }
}

void LevelIslands::writeIds(const std::vector<int>& island_of_node) {
  for (std::size_t tile = 0; tile < nodes_.size(); ++tile) {
    for (std::size_t i = 0; i < std::size_t(LevelLattice::kTileCells); ++i) {
      const int node = nodes_[tile][i];
      ids_[tile][i] = node < 0 ? -1 : islands_[std::size_t(island_of_node[std::size_t(node)])].id;
    }
  }
}

int LevelIslands::islandOf(const LevelLattice& lattice, const Cell& cell) const {
  const int tile = lattice.tileOf(cell);
  if (tile < 0 || std::size_t(tile) >= ids_.size()) return -1;
  return ids_[std::size_t(tile)][std::size_t(LevelLattice::indexInTile(cell))];
}

}  // namespace hymm::core
