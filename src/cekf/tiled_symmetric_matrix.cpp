#include "cekf/tiled_symmetric_matrix.h"

#include <algorithm>
#include <new>

namespace hymm::core {
namespace {

constexpr int kTile = TiledSymmetricMatrix::kTileSize;

double* allocateZeroTile() {
  // calloc takes zero pages from the system: a tile costs memory once it is written.
  void* memory = std::calloc(static_cast<std::size_t>(kTile) * kTile, sizeof(double));
  if (memory == nullptr) throw std::bad_alloc();
  return static_cast<double*>(memory);
}

}  // namespace

void TiledSymmetricMatrix::grow(int size) {
  const auto rows = static_cast<std::size_t>((size + kTile - 1) / kTile);
  for (; tile_rows_ < rows; ++tile_rows_) {
    for (std::size_t column = 0; column <= tile_rows_; ++column) {
      tiles_.emplace_back(allocateZeroTile());
    }
  }
}

void TiledSymmetricMatrix::copyTileColumn(int tile_row, int column, double* destination) const {
  const int tile_column = column / kTile, offset = column % kTile;
  if (tile_column < tile_row) {
    std::copy_n(tile(tile_row, tile_column) + offset * kTile, kTile, destination);
  } else if (tile_column > tile_row) {
    const double* source = tile(tile_column, tile_row) + offset;
    for (int i = 0; i < kTile; ++i) destination[i] = source[i * kTile];
  } else {
    const double* diagonal = tile(tile_row, tile_row);
    for (int i = 0; i < offset; ++i) destination[i] = diagonal[i * kTile + offset];
    std::copy_n(diagonal + offset * kTile + offset, kTile - offset, destination + offset);
  }
}

double* TiledSymmetricMatrix::entry(int row, int column) const {
  if (row < column) std::swap(row, column);
  return tiles_[tileIndex(row / kTile, column / kTile)].get() + (column % kTile) * kTile +
         row % kTile;
}

}  // namespace hymm::core
