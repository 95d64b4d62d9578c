#include "hybrid_map/cell_store.h"

#include <algorithm>

namespace hymm::core {

CellStore::CellStore(const LayerSet& layers, int cells)
    : cells_(cells),
      layers_(std::size_t(layers.count())),
      revisions_(std::size_t(layers.count()), 0) {}

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
  }
}

void CellStore::packOccupancy(const TriangularGrid& grid, float threshold,
                              std::uint64_t since_revision) {
  if (!isDue(LayerSet::kOccupancy, since_revision)) return;
  Layer& layer = layers_[LayerSet::kOccupancy];
  layer.tree = OccupancyQuadtree(grid, layer.content, threshold);
  layer.content = std::vector<float>();
}

void CellStore::forget(std::uint64_t revision) {
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    if (revisions_[i] == 0) continue;
    const std::size_t size = unpacked(static_cast<int>(i)).size();
    layers_[i] = {};
    layers_[i].packed = PackedFloats(std::vector<float>(size, 0.0F));
    revisions_[i] = revision;
  }
}

void CellStore::unpack(Layer& layer) {
  layer.content = layer.unpacked();
  layer.packed = {};
  layer.tree = {};
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
    sum.packed_bytes += layer.packed.bytes() + layer.tree.bytes();
    sum.packed_from_bytes += layer.packed.unpackedBytes() + layer.tree.unpackedBytes();
  }
}

}  // namespace hymm::core
