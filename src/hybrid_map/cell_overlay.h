#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "hybrid_map/cell_store.h"

namespace hymm::core {

/// A cell of a region.
struct CellPlace {
  CellStore* store = nullptr;
  int index = 0;
};

/// One of the equal parts of a cell of a layer, on its way into another region.
struct CellPart {
  int layer = 0;
  const float* cell = nullptr;
  float share = 0.0F;      ///< of the cell's evidence
  std::uint64_t seen = 0;  ///< when the cell was, see CellStore::seen()
  std::size_t count = 1;   ///< of the cell's parts
  /// Whether its evidence has been at a limit of its model since it began to come: then it says the
  /// same whatever was known before. Else both add up.
  bool was_at_limit = false;
};

/// One of `count` parts of a cell of a layer that is not empty.
CellPart partOf(const LayerSet& layers, const CellStore& store, int layer, int index,
                std::size_t count);

/// Lays evidence of some regions over that of others, as if what was seen later had been written on
/// top: where it has been at a limit since it began, it takes the place of what was seen earlier;
/// else both add up within the limits, as the beams of one grid do. Every part is told twice: all
/// of a grid to makeRoom(), then all to add(), since parts of several cells come to one and must
/// not make it forget each other: what was there before alone decides.
class CellOverlay {
 public:
  /// `layers` outlives the object; `revision` is the map's.
  CellOverlay(const LayerSet& layers, std::uint64_t revision)
      : layers_(layers), revision_(revision) {}

  /// Makes the cell forget for a later part. Layers whose model has no limits may be left out.
  void makeRoom(const CellPart& part, const CellPlace& place);

  /// Adds the part, unless a cell that was seen later does not depend on it.
  void add(const CellPart& part, const CellPlace& place);

  /// After each grid: what came from it is there.
  void finish();

 private:
  /// Of a region's layer, whose model has limits.
  struct Region {
    struct Cell {
      std::uint64_t seen = 0;     ///< before anything came, as far as it is known
      std::uint64_t newest = 0;   ///< of what is there and what comes
      bool was_at_limit = false;  ///< before anything came
      float forgotten = 0.0F;     ///< share of what was there
      float at_limit = 0.0F;      ///< share of what comes that was at a limit
    };
    std::vector<Cell> cells;
  };
  Region& regionOf(int layer, CellStore& store);
  float* cellAt(int layer, const CellPlace& place) const;

  const LayerSet& layers_;
  std::uint64_t revision_;
  using Key = std::pair<CellStore*, int>;  ///< and layer
  std::map<Key, Region> regions_;
  Key last_key_{nullptr, 0};
  Region* last_region_ = nullptr;
};

}  // namespace hymm::core
