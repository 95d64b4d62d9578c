#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "hybrid_map/cell_overlay.h"
#include "hybrid_map/hybrid_map_config.h"
#include "hybrid_map/ltr_cells.h"
#include "hybrid_map/ltr_partition.h"
#include "hybrid_map/waiting_tiles.h"

namespace hymm::core {

/// Cells of the LTRs of a partition, and those that wait for an LTR: whatever is written at a place
/// of the map goes where it belongs.
class LayerWriter {
 public:
  /// `layers` outlives the object.
  LayerWriter(const HybridMapConfig& config, const LayerSet& layers);

  /// What a change of the landmarks entails: sheets follow their anchors, new LTRs get cells and
  /// take what waited for them, and the content of retired ones moves to those that cover it now.
  void follow(LtrPartition& partition, const PartitionChange& change,
              const LandmarkPlaces& landmarks, std::uint64_t revision);

  /// Begins writing around a place.
  void begin(const Eigen::Vector2d& place, const LandmarkPlaces& landmarks, std::uint64_t revision);

  /// Adds `share` of a sample at a place in map.
  void addSample(LtrPartition& partition, int layer, const Eigen::Vector2d& place,
                 const LayerSample& sample, double share);

  LtrCells& cells(int ltr) { return *cells_[std::size_t(ltr)]; }
  const LtrCells* find(int ltr) const {
    return ltr >= 0 && std::size_t(ltr) < cells_.size() ? cells_[std::size_t(ltr)].get() : nullptr;
  }
  WaitingTiles& waiting() { return waiting_; }
  const WaitingTiles& waiting() const { return waiting_; }
  const LayerSet& layers() const { return layers_; }
  std::uint64_t revision() const { return revision_; }

  void save(StateWriter& archive) const;
  /// `partition`: of the same map.
  void restore(const LtrPartition& partition, StateReader& archive);

  double evidence(int layer) const;
  CellMemory memory() const;

  /// Compresses LTRs and tiles that do not reach into the vehicle's neighbourhood and were not
  /// written lately.
  void packBeyond(const LtrPartition& partition, const Eigen::Vector2d& vehicle);

  /// Forgets what the compressed LTRs hold, those first that were not written for longest, until
  /// all LTRs together fit the memory. Returns how many.
  std::size_t forgetBeyondLimit(LtrPartition& partition);

 private:
  /// The cell of an LTR that covers a place in map; nothing if none does.
  std::optional<CellPlace> cellInLtrs(const LtrPartition& partition, const Eigen::Vector2d& place);
  /// The same, or where nothing covers it one that waits. An LTR counts the share of an
  /// observation.
  CellPlace cellFor(LtrPartition& partition, const Eigen::Vector2d& place, double share);
  class Settler;
  void moveRetired(LtrPartition& partition, const RetiredLtr& retired,
                   const LandmarkPlaces& landmarks);

  const HybridMapConfig config_;
  const LayerSet& layers_;
  std::vector<std::unique_ptr<LtrCells>> cells_;  ///< by LTR; null for retired ones
  WaitingTiles waiting_;
  std::uint64_t revision_ = 0;
  int hint_ = kNone;  ///< LTR that was found last
};

}  // namespace hymm::core
