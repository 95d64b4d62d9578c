#include "hybrid_map/cell_overlay.h"

#include <algorithm>

#include "hybrid_map/cell_shares.h"

namespace hymm::core {

CellPart partOf(const LayerSet& layers, const CellStore& store, int layer, int index,
                std::size_t count) {
  return {layer,
          store.read(layers, layer, index),
          1.0F / static_cast<float>(count),
          store.seen(layer, index),
          count,
          store.wasAtLimit(layers, layer, index)};
}

CellOverlay::Region& CellOverlay::regionOf(int layer, CellStore& store) {
  const Key key(&store, layer);
  if (last_region_ != nullptr && key == last_key_) return *last_region_;
  Region& region = regions_[key];
  if (region.cells.empty()) {
    cellAt(layer, {&store, 0});  // which makes the cells
    for (int i = 0; i < store.cellCount(); ++i) {
      const std::uint64_t seen = store.seen(layer, i);
      region.cells.push_back({seen, seen, store.wasAtLimit(layers_, layer, i)});
    }
  }
  last_key_ = key;
  last_region_ = &region;
  return region;
}

float* CellOverlay::cellAt(int layer, const CellPlace& place) const {
  return place.store->rearrange(layers_, layer, revision_) +
         std::ptrdiff_t{place.index} * layers_.channels(layer);
}

void CellOverlay::makeRoom(const CellPart& part, const CellPlace& place) {
  if (!part.was_at_limit) return;
  Region::Cell& cell = regionOf(part.layer, *place.store).cells[std::size_t(place.index)];
  if (part.seen <= cell.seen || cell.forgotten >= 1.0F) return;
  const float before = cell.forgotten;
  cell.forgotten = std::min(1.0F, before + part.share);
  layers_.model(part.layer)
      .keep((1.0F - cell.forgotten) / (1.0F - before), cellAt(part.layer, place));
}

void CellOverlay::add(const CellPart& part, const CellPlace& place) {
  const CellModel& model = layers_.model(part.layer);
  if (!model.hasLimits()) {
    model.merge(part.cell, part.share, cellAt(part.layer, place));
    place.store->noteSeen(part.layer, place.index, part.seen);
    return;
  }
  Region::Cell& cell = regionOf(part.layer, *place.store).cells[std::size_t(place.index)];
  cell.newest = std::max(cell.newest, part.seen);
  if (part.was_at_limit) cell.at_limit += part.share;
  if (part.seen < cell.seen && cell.was_at_limit) return;
  model.merge(part.cell, part.share, cellAt(part.layer, place));
}

void CellOverlay::finish() {
  constexpr float kMost = 0.5F;  // of a cell's evidence
  for (auto& [key, region] : regions_) {
    auto& [store, layer] = key;
    const CellModel& model = layers_.model(layer);
    for (int i = 0; i < store->cellCount(); ++i) {
      Region::Cell& cell = region.cells[std::size_t(i)];
      const float* content = store->read(layers_, layer, i);
      if (!hasEvidence(content, layers_.channels(layer))) {  // or no more: what was there moved on
        cell = {};
        continue;
      }
      store->noteSeen(layer, i, cell.newest);
      // Whether it is at a limit can be read of it. Free space leaves it by a hit, which notes
      // that; an obstacle by a miss, which does not.
      const bool is_at_limit = model.isAtLimit(content);
      const bool is_noted =
          is_at_limit ? model.isOfOnePlace(content) : cell.was_at_limit || cell.at_limit >= kMost;
      if (is_noted) store->noteLimit(layer, i);
      cell = {cell.newest, cell.newest, is_noted || is_at_limit};
    }
  }
}

}  // namespace hymm::core
