#include "information_map/level_quadtree.h"

#include <set>
#include <utility>

namespace hymm::core {
namespace {

constexpr int kEdge = LevelLattice::kTileEdge;

class LeafCollector {
 public:
  LeafCollector(const LevelLattice& lattice, int level, const LevelIslands& islands)
      : lattice_(lattice), level_(level), islands_(islands) {}

  std::vector<LevelLeaf> collect() {
    Squares whole;
    for (int tile = 0; tile < lattice_.tileCount(); ++tile) {
      const LevelLattice::Tile& t = lattice_.tile(tile);
      if (isFull(t, 0, 0, kEdge)) {
        whole.insert({t.y, t.x});
      } else {
        split(t, 0, 0, kEdge);
      }
    }
    mergeWhole(std::move(whole), kEdge);
    return std::move(leaves_);
  }

 private:
  using Squares = std::set<std::pair<std::int32_t, std::int32_t>>;  // (y, x) in their edges

  bool isFull(const LevelLattice::Tile& tile, int x, int y, int edge) const {
    for (int row = y; row < y + edge; ++row) {
      for (int column = x; column < x + edge; ++column) {
        if (tile.levels[std::size_t(row * kEdge + column)] < level_) return false;
      }
    }
    return true;
  }

  void split(const LevelLattice::Tile& tile, int x, int y, int edge) {
    if (edge == 1) return;
    const int half = edge / 2;
    for (const auto& [dx, dy] : {std::pair{0, 0}, {half, 0}, {0, half}, {half, half}}) {
      if (isFull(tile, x + dx, y + dy, half)) {
        add({tile.x * kEdge + x + dx, tile.y * kEdge + y + dy}, half);
      } else {
        split(tile, x + dx, y + dy, half);
      }
    }
  }

  /// Joins four full squares to one of twice the edge for as long as there are any.
  void mergeWhole(Squares squares, std::int32_t edge) {
    while (!squares.empty()) {
      Squares larger;
      for (const auto& [y, x] : squares) {
        if (((x | y) & 1) != 0) continue;
        if (squares.count({y, x + 1}) + squares.count({y + 1, x}) + squares.count({y + 1, x + 1}) ==
            3) {
          larger.insert({y / 2, x / 2});
        }
      }
      for (const auto& [y, x] : squares) {
        if (larger.count({y >> 1, x >> 1}) == 0) add({x * edge, y * edge}, edge);
      }
      squares = std::move(larger);
      edge *= 2;
    }
  }

  void add(const Cell& first, std::int32_t edge) {
    LevelLeaf leaf;
    leaf.edge_m = edge * lattice_.resolution_m();
    leaf.centre = Eigen::Vector2d(first.x, first.y) * lattice_.resolution_m() +
                  Eigen::Vector2d::Constant(0.5 * leaf.edge_m);
    leaf.island = islands_.islandOf(lattice_, first);
    leaves_.push_back(leaf);
  }

  const LevelLattice& lattice_;
  int level_;
  const LevelIslands& islands_;
  std::vector<LevelLeaf> leaves_;
};

}  // namespace

std::vector<LevelLeaf> quadtreeLeaves(const LevelLattice& lattice, int level,
                                      const LevelIslands& islands) {
  return LeafCollector(lattice, level, islands).collect();
}

}  // namespace hymm::core
