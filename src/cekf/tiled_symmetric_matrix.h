#pragma once

#include <cstdlib>
#include <memory>
#include <vector>

#include <Eigen/Core>

namespace hymm::core {

/// A large symmetric matrix whose lower triangle is kept in square tiles, so that it grows without
/// copying, costs half the memory of a full one, and is updated tile by tile. Entries of a tile
/// that was never written are zero.
class TiledSymmetricMatrix {
 public:
  static constexpr int kTileSize = 128;

  /// Makes room for indices below `size`; what is there stays where it is.
  void grow(int size);

  int size() const { return static_cast<int>(tile_rows_) * kTileSize; }
  int tileRows() const { return static_cast<int>(tile_rows_); }

  double operator()(int row, int column) const { return *entry(row, column); }
  void set(int row, int column, double value) { *entry(row, column) = value; }

  /// Tile (I, J), I >= J, column-major with kTileSize rows. Of a diagonal tile only the lower
  /// triangle counts.
  double* tile(int tile_row, int tile_column) {
    return tiles_[tileIndex(tile_row, tile_column)].get();
  }
  const double* tile(int tile_row, int tile_column) const {
    return tiles_[tileIndex(tile_row, tile_column)].get();
  }

  /// Entries of rows [first_row, first_row + kTileSize) of tile row `tile_row` in column `column`.
  void copyTileColumn(int tile_row, int column, double* destination) const;

 private:
  struct Free {
    void operator()(double* memory) const { std::free(memory); }
  };

  static std::size_t tileIndex(int row, int column) {
    const auto r = static_cast<std::size_t>(row);
    return r * (r + 1) / 2 + static_cast<std::size_t>(column);
  }

  double* entry(int row, int column) const;

  std::size_t tile_rows_ = 0;
  std::vector<std::unique_ptr<double, Free>> tiles_;  ///< lower triangle, row by row
};

}  // namespace hymm::core
