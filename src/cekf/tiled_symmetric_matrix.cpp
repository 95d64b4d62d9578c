#include "cekf/tiled_symmetric_matrix.h"

#include <algorithm>
#include <iterator>
#include <new>
#include <utility>

namespace hymm::core {
namespace {

constexpr int kTile = TiledSymmetricMatrix::kTileSize;

}  // namespace

TiledSymmetricMatrix::Tile TiledSymmetricMatrix::newTile() {
  void* memory = std::calloc(static_cast<std::size_t>(kTile) * kTile, sizeof(double));
  if (memory == nullptr) throw std::bad_alloc();
  return Tile(static_cast<double*>(memory));
}

std::size_t TiledSymmetricMatrix::tilesToGrow(int size) const {
  const std::size_t rows = std::max(tileRowsFor(size), tile_rows_);
  return rows * (rows + 1) / 2 - tiles_.size();
}

void TiledSymmetricMatrix::grow(int size, std::vector<Tile> tiles) {
  tile_rows_ = std::max(tileRowsFor(size), tile_rows_);
  std::move(tiles.begin(), tiles.end(), std::back_inserter(tiles_));
}

double TiledSymmetricMatrix::operator()(int row, int column) const {
  if (row < column) std::swap(row, column);
  return tile(row / kTile, column / kTile)[(column % kTile) * kTile + row % kTile];
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

}  // namespace hymm::core
