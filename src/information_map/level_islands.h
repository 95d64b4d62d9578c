#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "information_map/level_lattice.h"

namespace hymm::core {

/// A connected part of a level set.
struct Island {
  int id = -1;
  std::size_t cells = 0;
  Cell first;  ///< one of its cells
};

/// An island that is part of another one since the last update.
struct JoinedIsland {
  int id = -1;
  int into_id = -1;
};

/// The islands of one level set, with ids that persist: an island keeps its id while it grows and
/// shrinks; one that falls apart leaves it to its largest part; islands that join take the id of
/// that which gave most cells. Ids are never used again.
class LevelIslands {
 public:
  explicit LevelIslands(int level) : level_(level) {}

  /// Finds the islands anew. Cells that share a side are connected.
  void update(const LevelLattice& lattice);

  /// Largest first.
  const std::vector<Island>& islands() const { return islands_; }
  /// By the last update.
  const std::vector<JoinedIsland>& joined() const { return joined_; }

  /// Id of the island that holds a cell, or -1.
  int islandOf(const LevelLattice& lattice, const Cell& cell) const;

 private:
  using TileLabels = std::array<std::int32_t, LevelLattice::kTileCells>;
  void labelTile(const LevelLattice& lattice, int tile);
  int rootOf(int node);
  void unite(int a, int b);
  struct CommonCells {
    int old_id, island;
    std::size_t cells;
  };
  void connectTile(const LevelLattice& lattice, int tile);
  std::vector<CommonCells> countCommonCells(const std::vector<int>& island_of_node) const;
  void inheritIds(const std::vector<CommonCells>& pairs);
  void writeIds(const std::vector<int>& island_of_node);

  int level_;
  int next_id_ = 0;
  std::vector<TileLabels> ids_;    ///< by tile and cell: island id or -1
  std::vector<TileLabels> nodes_;  ///< by tile and cell: provisional label or -1
  std::vector<int> parents_;       ///< of nodes
  std::vector<Island> islands_;
  std::vector<JoinedIsland> joined_;
};

}  // namespace hymm::core
