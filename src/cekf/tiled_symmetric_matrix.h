#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <vector>

namespace hymm::core {

class StateReader;
class StateWriter;

/// A large symmetric matrix whose lower triangle is kept in square tiles, so that it grows without
/// copying, costs half the memory of a full one, and is replaced tile by tile. Entries of a tile
/// that was never written are zero.
class TiledSymmetricMatrix {
 public:
  static constexpr int kTileSize = 128;

  struct Free {
    void operator()(double* memory) const { std::free(memory); }
  };
  /// kTileSize x kTileSize, column-major.
  using Tile = std::unique_ptr<double, Free>;

  /// A tile of zeros, which costs memory once it is written. Throws std::bad_alloc.
  static Tile newTile();

  /// How many tiles more it takes to hold indices below `size`.
  std::size_t tilesToGrow(int size) const;

  /// Makes room for indices below `size` with tilesToGrow(size) tiles; what is there stays where it
  /// is. Allocates nothing of the size of a tile, so that a lock need not be held for long.
  void grow(int size, std::vector<Tile> tiles);

  int size() const { return static_cast<int>(tile_rows_) * kTileSize; }
  int tileRows() const { return static_cast<int>(tile_rows_); }

  double operator()(int row, int column) const;

  /// Tile (I, J), I >= J. Of a diagonal tile only the lower triangle counts.
  const double* tile(int tile_row, int tile_column) const {
    return tiles_[tileIndex(tile_row, tile_column)].get();
  }

  /// Puts `tile` in the place of tile (I, J), I >= J, and gives back what was there.
  void exchangeTile(int tile_row, int tile_column, Tile& tile) {
    tiles_[tileIndex(tile_row, tile_column)].swap(tile);
  }

  /// Entries of rows [tile_row * kTileSize, (tile_row + 1) * kTileSize) in column `column`.
  void copyTileColumn(int tile_row, int column, double* destination) const;

  void save(StateWriter& archive) const;
  void restore(StateReader& archive);

 private:
  static std::size_t tileRowsFor(int size) {
    return static_cast<std::size_t>((size + kTileSize - 1) / kTileSize);
  }
  static std::size_t tileIndex(int row, int column) {
    const auto r = static_cast<std::size_t>(row);
    return r * (r + 1) / 2 + static_cast<std::size_t>(column);
  }

  std::size_t tile_rows_ = 0;
  std::vector<Tile> tiles_;  ///< lower triangle, row by row
};

}  // namespace hymm::core
