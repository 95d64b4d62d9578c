#pragma once

#include <array>
#include <utility>
#include <vector>

#include "hybrid_map/cell_shares.h"
#include "hybrid_map/cell_store.h"
#include "hybrid_map/triangular_grid.h"

namespace hymm::core {

/// The cells of an LTR in all layers.
struct LtrCells {
  LtrCells(const LayerSet& layers, const Triangle& triangle, double resolution_m)
      : LtrCells(layers, TriangularGrid(triangle, resolution_m)) {}
  LtrCells(const LayerSet& layers, TriangularGrid cells)
      : grid(std::move(cells)), store(layers, grid.cellCount()) {}

  TriangularGrid grid;
  CellStore store;
};

/// Calls `visit(layer, index, parts, count)` for each cell with evidence: the local coordinates of
/// the centres of its parts that lie inside the LTR, between which its evidence is shared equally.
template <class Visitor>
void visitCells(const LtrCells& cells, const LayerSet& layers, Visitor&& visitor) {
  std::array<Triangle::Local, kCellParts.size()> parts;
  for (int layer = 0; layer < layers.count(); ++layer) {
    if (cells.store.isEmpty(layer)) continue;
    int index = 0;
    for (int j = 0; j < cells.grid.betaCells(); ++j) {
      for (int i = 0; i < cells.grid.rowLength(j); ++i, ++index) {
        const float* cell = cells.store.read(layers, layer, index);
        if (!hasEvidence(cell, layers.channels(layer))) continue;
        const auto localOf = [&](const Eigen::Vector2d& part) {
          return Triangle::Local((i + part.x()) / cells.grid.alphaCells(),
                                 (j + part.y()) / cells.grid.betaCells());
        };
        const std::size_t whole = partsOf(layers.model(layer), cell);
        std::size_t count = 0;
        for (std::size_t part = 0; part < kCellParts.size() && count < whole; ++part) {
          parts[count] = localOf(kCellParts[part]);
          if (Triangle::containsLocal(parts[count])) ++count;
        }
        // Of a cell that the triangle hardly touches, its corner lies inside.
        if (count == 0) parts[count++] = localOf(Eigen::Vector2d::Zero());
        visitor(layer, index, parts, count);
      }
    }
  }
}

}  // namespace hymm::core
