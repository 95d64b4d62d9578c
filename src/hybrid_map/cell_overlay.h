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
};

/// Lays evidence of some regions over that of others, as if what was seen later had been written on
/// top. Every part is told twice: all of a grid to makeRoom(), then all to add(), since parts of
/// several cells come to one and must not make it forget each other: what was there before alone
/// decides.
class CellOverlay {
 public:
  /// `layers` outlives the object; `revision` is the map's.
  CellOverlay(const LayerSet& layers, std::uint64_t revision)
      : layers_(layers), revision_(revision) {}

  /// Makes the cell forget what contradicts a later part. Layers whose model forgets nothing may be
  /// left out.
  void makeRoom(const CellPart& part, const CellPlace& place);

  /// Adds the part, less what contradicts a cell that was seen later.
  void add(const CellPart& part, const CellPlace& place);

  /// After each grid: what came from it is there.
  void finish();

 private:
  /// Of the cells of a region's layer, whose model forgets.
  struct Region {
    std::vector<float> content;         ///< before anything came
    std::vector<std::uint64_t> seen;    ///< likewise, as far as it is known
    std::vector<std::uint64_t> newest;  ///< of what is there and what comes
  };
  Region& regionOf(int layer, CellStore& store);
  float* cellAt(int layer, const CellPlace& place) const;

  const LayerSet& layers_;
  std::uint64_t revision_;
  using Key = std::pair<CellStore*, int>;  ///< and layer
  std::map<Key, Region> regions_;
  Key last_key_{nullptr, 0};
  Region* last_region_ = nullptr;
  std::vector<float> earlier_;  ///< a cell
};

}  // namespace hymm::core
