#include "hybrid_map/cell_overlay.h"

#include <algorithm>

namespace hymm::core {

CellOverlay::Region& CellOverlay::regionOf(int layer, CellStore& store) {
  const Key key(&store, layer);
  if (last_region_ != nullptr && key == last_key_) return *last_region_;
  Region& region = regions_[key];
  if (region.content.empty()) {
    cellAt(layer, {&store, 0});  // which makes the cells
    region.content = store.content(layer);
    for (int i = 0; i < store.cellCount(); ++i) region.seen.push_back(store.seen(layer, i));
    region.newest = region.seen;
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
  const Region& region = regionOf(part.layer, *place.store);
  if (part.seen <= region.seen[std::size_t(place.index)]) return;
  layers_.model(part.layer).yieldTo(part.cell, part.share, cellAt(part.layer, place));
}

void CellOverlay::add(const CellPart& part, const CellPlace& place) {
  const CellModel& model = layers_.model(part.layer);
  float* cell = cellAt(part.layer, place);
  if (!model.forgets()) {
    model.merge(part.cell, part.share, cell);
    place.store->noteSeen(part.layer, place.index, part.seen);
    return;
  }
  Region& region = regionOf(part.layer, *place.store);
  const auto index = std::size_t(place.index);
  region.newest[index] = std::max(region.newest[index], part.seen);
  if (part.seen >= region.seen[index]) {
    model.merge(part.cell, part.share, cell);
    return;
  }
  const std::ptrdiff_t channels = layers_.channels(part.layer);
  earlier_.assign(part.cell, part.cell + channels);
  model.yieldTo(region.content.data() + place.index * channels, 1.0F, earlier_.data());
  model.merge(earlier_.data(), part.share, cell);
}

void CellOverlay::finish() {
  for (auto& [key, region] : regions_) {
    auto& [store, layer] = key;
    for (int i = 0; i < store->cellCount(); ++i) {
      store->noteSeen(layer, i, region.newest[std::size_t(i)]);
    }
    region.content = store->content(layer);
    region.seen = region.newest;
  }
}

}  // namespace hymm::core
