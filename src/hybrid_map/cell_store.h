#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hybrid_map/layer_set.h"

namespace hymm::core {

/// Cells of one region (an LTR or a tile) in all layers; a layer takes memory once it is written.
class CellStore {
 public:
  CellStore(const LayerSet& layers, int cells) : cells_(cells) {
    content_.resize(std::size_t(layers.count()));
    revisions_.resize(std::size_t(layers.count()), 0);
  }

  int cellCount() const { return cells_; }
  bool isEmpty(int layer) const { return content_[std::size_t(layer)].empty(); }

  /// All cells of a layer for writing, `revision` being the map's.
  float* write(const LayerSet& layers, int layer, std::uint64_t revision) {
    std::vector<float>& content = content_[std::size_t(layer)];
    if (content.empty()) content.resize(std::size_t(cells_) * std::size_t(layers.channels(layer)));
    revisions_[std::size_t(layer)] = revision;
    return content.data();
  }

  /// A cell of a layer that is not empty.
  const float* read(const LayerSet& layers, int layer, int cell) const {
    return content_[std::size_t(layer)].data() + std::ptrdiff_t{cell} * layers.channels(layer);
  }
  const std::vector<float>& content(int layer) const { return content_[std::size_t(layer)]; }

  /// The map's revision when the layer was last written; 0: never.
  std::uint64_t revision(int layer) const { return revisions_[std::size_t(layer)]; }
  std::uint64_t lastRevision() const {
    std::uint64_t last = 0;
    for (const std::uint64_t revision : revisions_) last = std::max(last, revision);
    return last;
  }

  std::size_t bytes() const {
    std::size_t bytes = 0;
    for (const auto& layer : content_) bytes += layer.capacity() * sizeof(float);
    return bytes;
  }

 private:
  int cells_;
  std::vector<std::vector<float>> content_;  ///< by layer; channels of a cell side by side
  std::vector<std::uint64_t> revisions_;
};

}  // namespace hymm::core
