#include "hybrid_map/cell_store.h"

#include <algorithm>

namespace hymm::core {

CellStore::CellStore(const LayerSet& layers, int cells, Seen seen)
    : cells_(cells),
      layers_(std::size_t(layers.count())),
      revisions_(std::size_t(layers.count()), 0),
      seen_(std::size_t(layers.count()), 0) {
  if (seen == Seen::kLayers) return;
  for (int i = 0; i < layers.count(); ++i) {
    layers_[std::size_t(i)].keeps_seen_cells = layers.model(i).hasLimits();
  }
}

/// Of cells that were just unpacked, or made.
void CellStore::beginSeenCells(int layer) const {
  Layer& begun = layers_[std::size_t(layer)];
  if (!begun.keeps_seen_cells) return;
  begun.seen_cells.assign(std::size_t(cells_), static_cast<Stamp>(seen_[std::size_t(layer)]));
}

void CellStore::noteSeen(int layer, int cell, std::uint64_t revision) {
  std::uint64_t& seen = seen_[std::size_t(layer)];
  seen = std::max(seen, revision);
  Stamp* cells = seenCells(layer);
  if (cells == nullptr) return;
  cells[cell] = std::max(cells[cell], static_cast<Stamp>(revision));
}

void CellStore::keep(const LayerSet& layers, int layer, int cell, float share) {
  std::vector<float>& content = unpacked(layer);
  Layer& kept = layers_[std::size_t(layer)];
  if (share <= 0.0F) {
    kept.noted_at_limit.reset(cell);
    if (Stamp* seen = seenCells(layer)) seen[cell] = 0;
  } else if (wasAtLimit(layers, layer, cell)) {
    noteLimit(layer, cell);
  }
  layers.model(layer).keep(share, content.data() + std::ptrdiff_t{cell} * layers.channels(layer));
}

bool CellStore::isDue(int layer, std::uint64_t since_revision) const {
  const auto i = std::size_t(layer);
  return !layers_[i].content.empty() && revisions_[i] < since_revision;
}

void CellStore::pack(std::uint64_t since_revision) {
  for (int i = 0; i < static_cast<int>(layers_.size()); ++i) {
    if (!isDue(i, since_revision)) continue;
    Layer& layer = layers_[std::size_t(i)];
    layer.packed = PackedFloats(layer.content);
    layer.content = std::vector<float>();  // its memory is given back, as clear() would not
    layer.seen_cells = std::vector<Stamp>();
    layer.noted_at_limit.pack();
  }
}

void CellStore::packOccupancy(const TriangularGrid& grid, float threshold,
                              std::uint64_t since_revision) {
  if (!isDue(LayerSet::kOccupancy, since_revision)) return;
  Layer& layer = layers_[LayerSet::kOccupancy];
  layer.tree = OccupancyQuadtree(grid, layer.content, threshold);
  layer.content = std::vector<float>();
  layer.seen_cells = std::vector<Stamp>();
  layer.noted_at_limit.pack();
}

void CellStore::forget(std::uint64_t revision) {
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    if (revisions_[i] == 0) continue;
    const std::size_t size = unpacked(static_cast<int>(i)).size();
    layers_[i].content = std::vector<float>();
    layers_[i].seen_cells = std::vector<Stamp>();
    layers_[i].noted_at_limit = {};
    layers_[i].tree = {};
    layers_[i].packed = PackedFloats(std::vector<float>(size, 0.0F));
    revisions_[i] = revision;
    seen_[i] = 0;
  }
}

void CellStore::unpack(int layer) const {
  Layer& packed = layers_[std::size_t(layer)];
  packed.content = packed.unpacked();
  packed.packed = {};
  packed.tree = {};
  packed.noted_at_limit.unpack();
  beginSeenCells(layer);
}

const std::vector<float>& CellStore::peek(int layer, std::vector<float>& buffer) const {
  const Layer& wanted = layers_[std::size_t(layer)];
  if (!wanted.isPacked()) return wanted.content;
  buffer = wanted.unpacked();
  return buffer;
}

std::uint64_t CellStore::lastRevision() const {
  return *std::max_element(revisions_.begin(), revisions_.end());
}

void CellStore::addMemory(CellMemory& sum) const {
  for (const Layer& layer : layers_) {
    sum.unpacked_bytes += layer.content.capacity() * sizeof(float);
    sum.unpacked_bytes += layer.seen_cells.capacity() * sizeof(Stamp);
    sum.unpacked_bytes += layer.noted_at_limit.unpackedBytes();
    sum.packed_bytes +=
        layer.packed.bytes() + layer.tree.bytes() + layer.noted_at_limit.packedBytes();
    sum.packed_from_bytes += layer.packed.unpackedBytes() + layer.tree.unpackedBytes() +
                             layer.noted_at_limit.packedFromBytes();
  }
}

}  // namespace hymm::core
