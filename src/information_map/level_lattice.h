#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

namespace hymm::core {

/// A cell of the lattice that level sets are made of: the smallest leaf of their quadtrees.
struct Cell {
  std::int32_t x = 0, y = 0;
  bool operator==(const Cell& other) const { return x == other.x && y == other.y; }
};

/// Nested level sets over square cells: each cell holds how many of the values are reached at its
/// centre, so that a set holds every set of a higher value (23) by construction. Cells lie in
/// tiles, which are made where something is written and keep their number.
class LevelLattice {
 public:
  static constexpr int kTileBits = 4;
  static constexpr int kTileEdge = 1 << kTileBits;  ///< cells along a tile's side
  static constexpr int kTileCells = kTileEdge * kTileEdge;

  struct Tile {
    std::int32_t x = 0, y = 0;  ///< of the first cell, in tiles
    std::array<std::uint8_t, kTileCells> levels{};
  };

  /// The four cells that share a side with a cell.
  static constexpr std::array<Cell, 4> kNeighbours = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

  LevelLattice(double resolution_m, int levels)
      : resolution_m_(resolution_m), cells_reaching_(std::size_t(levels) + 1, 0) {}

  double resolution_m() const { return resolution_m_; }
  double cellArea_m2() const { return resolution_m_ * resolution_m_; }
  int levels() const { return static_cast<int>(cells_reaching_.size()) - 1; }

  Cell cellAt(const Eigen::Vector2d& place) const {
    return {static_cast<std::int32_t>(std::floor(place.x() / resolution_m_)),
            static_cast<std::int32_t>(std::floor(place.y() / resolution_m_))};
  }
  Eigen::Vector2d centre(const Cell& cell) const {
    return {(cell.x + 0.5) * resolution_m_, (cell.y + 0.5) * resolution_m_};
  }

  /// 0 where no value is reached, or nothing was written.
  int level(const Cell& cell) const {
    const int tile = tileOf(cell);
    return tile < 0 ? 0 : tiles_[std::size_t(tile)].levels[std::size_t(indexInTile(cell))];
  }
  int levelAt(const Eigen::Vector2d& place) const { return level(cellAt(place)); }

  void set(const Cell& cell, int level);

  /// Cells that reach at least `level`, from 1 on.
  std::size_t cellsReaching(int level) const { return cells_reaching_[std::size_t(level)]; }
  double area_m2(int level) const {
    return static_cast<double>(cellsReaching(level)) * cellArea_m2();
  }

  /// Tile of a cell, or -1.
  int tileOf(const Cell& cell) const {
    const auto found = tile_of_key_.find(keyOf(cell.x >> kTileBits, cell.y >> kTileBits));
    return found == tile_of_key_.end() ? -1 : found->second;
  }
  int makeTileOf(const Cell& cell);
  int tileCount() const { return static_cast<int>(tiles_.size()); }
  const Tile& tile(int index) const { return tiles_[std::size_t(index)]; }
  static int indexInTile(const Cell& cell) {
    return (cell.y & (kTileEdge - 1)) << kTileBits | (cell.x & (kTileEdge - 1));
  }
  /// Whether one of the four cells around has another level.
  bool isBorder(int tile, int index_in_tile) const;
  Cell cellOf(int tile, int index_in_tile) const {
    const Tile& t = tiles_[std::size_t(tile)];
    return {t.x * kTileEdge + (index_in_tile & (kTileEdge - 1)),
            t.y * kTileEdge + (index_in_tile >> kTileBits)};
  }

 private:
  static std::uint64_t keyOf(std::int32_t x, std::int32_t y) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)) << 32U |
           static_cast<std::uint32_t>(y);
  }

  double resolution_m_;
  std::vector<Tile> tiles_;
  std::unordered_map<std::uint64_t, int> tile_of_key_;
  std::vector<std::size_t> cells_reaching_;
};

/// Cells in both sets of a level over cells in one of them; 1 where both are empty.
double intersectionOverUnion(const LevelLattice& a, const LevelLattice& b, int level);

}  // namespace hymm::core
