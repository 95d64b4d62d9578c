/// How what waited moves into LTRs that cover it now.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "hybrid_map/cell_shares.h"
#include "hybrid_map/waiting_tiles.h"

namespace hymm::core {
namespace {

using Box = WaitingTiles::Box;

/// The boxes that a square around `place`, `reach_m` to each side, touches.
std::vector<Box> boxesAt(const Eigen::Vector2d& place, double reach_m,
                         const std::vector<Box>& boxes) {
  std::vector<Box> near;
  std::copy_if(boxes.begin(), boxes.end(), std::back_inserter(near), [&](const Box& box) {
    return (place.array() + reach_m >= box.low.array()).all() &&
           (place.array() - reach_m <= box.high.array()).all();
  });
  return near;
}

}  // namespace

/// A tile that touches boxes.
struct WaitingTiles::SettlingTile {
  Sheet* sheet = nullptr;
  TilePlace place;
  CellStore* cells = nullptr;
  std::vector<Box> boxes;
  double resolution_m = 0.0;
  bool is_left = false;  ///< whether something stays here

  /// In map, of a part (in units of the cell) of the cell with this index.
  Eigen::Vector2d placeOf(int index, const Eigen::Vector2d& part) const {
    const Eigen::Vector2d corner(place.first * kTileCells + index % kTileCells,
                                 place.second * kTileCells + index / kTileCells);
    return sheet->T_map_sheet * (resolution_m * (corner + part));
  }
  bool mayBeCovered(int index) const {
    return !boxesAt(placeOf(index, {0.5, 0.5}), resolution_m * M_SQRT1_2, boxes).empty();
  }
};

std::vector<WaitingTiles::SettlingTile> WaitingTiles::tilesWithin(const std::vector<Box>& boxes,
                                                                  Sheet& sheet) {
  const double tile_m = kTileCells * resolution_m_;
  std::vector<SettlingTile> within;
  for (auto& [place, cells] : sheet.tiles) {
    const Eigen::Vector2d middle(place.first + 0.5, place.second + 0.5);
    std::vector<Box> near =
        boxesAt(sheet.T_map_sheet * (tile_m * middle), tile_m * M_SQRT1_2, boxes);
    if (near.empty()) continue;
    within.push_back({&sheet, place, &cells, std::move(near), resolution_m_});
  }
  return within;
}

void WaitingTiles::settle(const std::vector<Box>& boxes, Taker& taker) {
  last_tile_ = nullptr;
  for (Sheet& sheet : sheets_) {
    std::vector<SettlingTile> tiles = tilesWithin(boxes, sheet);
    for (int layer = 0; layer < layers_.count(); ++layer) {
      if (layers_.model(layer).hasLimits()) {
        for (const SettlingTile& tile : tiles) makeRoom(tile, layer, taker);
      }
      for (SettlingTile& tile : tiles) settleLayer(tile, layer, taker);
    }
    if (!tiles.empty()) taker.finish();
    for (const SettlingTile& tile : tiles) {
      if (!tile.is_left) sheet.tiles.erase(tile.place);
    }
  }
}

void WaitingTiles::makeRoom(const SettlingTile& tile, int layer, Taker& taker) {
  if (tile.cells->isEmpty(layer)) return;
  for (int index = 0; index < tile.cells->cellCount(); ++index) {
    const float* cell = tile.cells->read(layers_, layer, index);
    if (!hasEvidence(cell, layers_.channels(layer)) || !tile.mayBeCovered(index)) continue;
    const CellPart part = movingPart(*tile.cells, layer, index);
    for (std::size_t i = 0; i < part.count; ++i) {
      taker.makeRoom(part, tile.placeOf(index, kCellParts[i]));
    }
  }
}

void WaitingTiles::settleLayer(SettlingTile& tile, int layer, Taker& taker) {
  CellStore& store = *tile.cells;
  if (store.isEmpty(layer)) return;
  const int channels = layers_.channels(layer);
  float* cell = store.rearrange(layers_, layer, store.revision(layer));
  for (int index = 0; index < store.cellCount(); ++index, cell += channels) {
    if (!hasEvidence(cell, channels)) continue;
    if (!tile.mayBeCovered(index)) {
      tile.is_left = true;
      continue;
    }
    const CellPart part = movingPart(store, layer, index);
    std::size_t left = part.count;
    for (std::size_t i = 0; i < part.count; ++i) {
      if (taker.take(part, tile.placeOf(index, kCellParts[i]))) --left;
    }
    store.keep(layers_, layer, index, static_cast<float>(left) * part.share);
    tile.is_left = tile.is_left || left > 0;
  }
}

}  // namespace hymm::core
