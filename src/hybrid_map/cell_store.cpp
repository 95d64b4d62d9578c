#include "hybrid_map/cell_store.h"

#include <algorithm>

namespace hymm::core {

CellStore::CellStore(const LayerSet& layers, int cells)
    : cells_(cells),
      layers_(std::size_t(layers.count())),
      revisions_(std::size_t(layers.count()), 0) {}

void CellStore::pack(std::uint64_t since_revision) {
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    Layer& layer = layers_[i];
    if (layer.content.empty() || revisions_[i] >= since_revision) continue;
    layer.packed = PackedFloats(layer.content);
    layer.content = std::vector<float>();  // its memory is given back, as clear() would not
  }
}

void CellStore::unpack(Layer& layer) {
  layer.content = layer.packed.unpack();
  layer.packed = {};
}

const std::vector<float>& CellStore::peek(int layer, std::vector<float>& buffer) const {
  const Layer& wanted = layers_[std::size_t(layer)];
  if (wanted.packed.isEmpty()) return wanted.content;
  buffer = wanted.packed.unpack();
  return buffer;
}

std::uint64_t CellStore::lastRevision() const {
  return *std::max_element(revisions_.begin(), revisions_.end());
}

void CellStore::addMemory(CellMemory& sum) const {
  for (const Layer& layer : layers_) {
    sum.unpacked_bytes += layer.content.capacity() * sizeof(float);
    sum.packed_bytes += layer.packed.bytes();
    sum.packed_from_bytes += layer.packed.unpackedBytes();
  }
}

}  // namespace hymm::core
