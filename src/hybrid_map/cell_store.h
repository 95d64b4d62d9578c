#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hybrid_map/cell_marks.h"
#include "hybrid_map/layer_set.h"
#include "hybrid_map/occupancy_quadtree.h"
#include "hybrid_map/packed_floats.h"

namespace hymm::core {

class StateReader;
class StateWriter;

/// Memory that cells take.
struct CellMemory {
  std::size_t unpacked_bytes = 0;
  std::size_t packed_bytes = 0;       ///< of cells that are compressed
  std::size_t packed_from_bytes = 0;  ///< the same cells, were they not

  std::size_t bytes() const { return unpacked_bytes + packed_bytes; }
};

/// Cells of one region (an LTR or a tile) in all layers. A layer takes memory once it is written;
/// it can be packed, and unpacks itself where it is next looked at or written.
class CellStore {
 public:
  /// Of which it is known when they were seen: each layer as a whole, or, where the layer's model
  /// has limits, each cell until it is packed.
  enum class Seen { kLayers, kCells };

  CellStore(const LayerSet& layers, int cells, Seen seen = Seen::kLayers);

  int cellCount() const { return cells_; }
  bool isEmpty(int layer) const { return revisions_[std::size_t(layer)] == 0; }

  /// All cells of a layer for writing, `revision` (greater than 0) being the map's.
  float* write(const LayerSet& layers, int layer, std::uint64_t revision) {
    std::vector<float>& content = unpacked(layer);
    if (content.empty()) {
      content.resize(std::size_t(cells_) * std::size_t(layers.channels(layer)));
      beginSeenCells(layer);
    }
    revisions_[std::size_t(layer)] = seen_[std::size_t(layer)] = revision;
    return content.data();
  }

  /// The same for what moves from one region to another, of which nothing is seen anew.
  float* rearrange(const LayerSet& layers, int layer, std::uint64_t revision) {
    const std::uint64_t seen = seen_[std::size_t(layer)];
    float* content = write(layers, layer, revision);
    seen_[std::size_t(layer)] = seen;
    return content;
  }

  /// A cell of a layer that is not empty.
  const float* read(const LayerSet& layers, int layer, int cell) const {
    return unpacked(layer).data() + std::ptrdiff_t{cell} * layers.channels(layer);
  }
  /// All cells of a layer, the channels of each side by side; empty if it was never written.
  const std::vector<float>& content(int layer) const { return unpacked(layer); }

  /// The same without unpacking for good: cells that are packed are unpacked into `buffer`.
  const std::vector<float>& peek(int layer, std::vector<float>& buffer) const;

  /// Compresses layers that were not written since a revision, without loss.
  void pack(std::uint64_t since_revision);

  /// Compresses the occupancy with loss, if it was not written since a revision. `grid`: of these
  /// cells; `threshold`: see OccupancyQuadtree.
  void packOccupancy(const TriangularGrid& grid, float threshold, std::uint64_t since_revision);

  /// Takes all that is known out of the layers; to readers they were written with `revision`.
  void forget(std::uint64_t revision);

  /// The map's revision when the layer was last written; 0: never.
  std::uint64_t revision(int layer) const { return revisions_[std::size_t(layer)]; }
  std::uint64_t lastRevision() const;

  /// The map's revision when something was last observed of what the layer holds, here or where it
  /// came from; 0: never.
  std::uint64_t seen(int layer) const { return seen_[std::size_t(layer)]; }
  /// The same of a cell, as far as it is known.
  std::uint64_t seen(int layer, int cell) const {
    const auto& cells = layers_[std::size_t(layer)].seen_cells;
    return cells.empty() ? seen_[std::size_t(layer)] : cells[std::size_t(cell)];
  }
  void noteSeen(int layer, int cell, std::uint64_t revision);

  /// A revision, in the memory of cells.
  using Stamp = std::uint32_t;
  /// When each cell was seen, for those who write() cells of it; null where it is not known.
  Stamp* seenCells(int layer) {
    std::vector<Stamp>& cells = layers_[std::size_t(layer)].seen_cells;
    return cells.empty() ? nullptr : cells.data();
  }

  /// Whether a cell of a layer that is not empty has been at a limit of its model since its
  /// evidence began to come here, be it that it is there now, or that it was noted.
  bool wasAtLimit(const LayerSet& layers, int layer, int cell) const {
    const CellModel& model = layers.model(layer);
    return model.hasLimits() && (model.isAtLimit(read(layers, layer, cell)) ||
                                 layers_[std::size_t(layer)].noted_at_limit.has(cell));
  }
  /// Of a cell that leaves a limit, or may without being looked at.
  void noteLimit(int layer, int cell) {
    unpacked(layer);
    layers_[std::size_t(layer)].noted_at_limit.set(cell, cells_);
  }

  /// Leaves `share` of a cell's evidence here; the rest went elsewhere.
  void keep(const LayerSet& layers, int layer, int cell, float share);

  void addMemory(CellMemory& sum) const;

  /// What was compressed comes back compressed without loss.
  void save(StateWriter& archive) const;
  void restore(const LayerSet& layers, StateReader& archive);

 private:
  struct Layer {
    bool isPacked() const { return !packed.isEmpty() || !tree.isEmpty(); }
    std::vector<float> unpacked() const { return tree.isEmpty() ? packed.unpack() : tree.unpack(); }

    std::vector<float> content;  ///< empty while one of these is not:
    PackedFloats packed;
    OccupancyQuadtree tree;
    bool keeps_seen_cells = false;
    std::vector<Stamp> seen_cells;  ///< empty while packed
    CellMarks noted_at_limit;
  };
  std::vector<float>& unpacked(int layer) const {
    Layer& wanted = layers_[std::size_t(layer)];
    if (wanted.isPacked()) unpack(layer);
    return wanted.content;
  }
  void unpack(int layer) const;
  void beginSeenCells(int layer) const;
  bool isDue(int layer, std::uint64_t since_revision) const;

  int cells_;
  mutable std::vector<Layer> layers_;
  std::vector<std::uint64_t> revisions_, seen_;  ///< by layer
};

}  // namespace hymm::core
