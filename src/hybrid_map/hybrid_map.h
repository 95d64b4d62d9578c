#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "cekf/landmark_map.h"
#include "common/pose2.h"
#include "hybrid_map/hybrid_map_config.h"
#include "hybrid_map/layer_set.h"
#include "hybrid_map/ltr_cells.h"
#include "hybrid_map/ltr_partition.h"
#include "hybrid_map/ltr_topology.h"
#include "hybrid_map/property_sample.h"
#include "hybrid_map/waiting_tiles.h"
#include "perception/laser_scan.h"

namespace hymm::core {

/// A scan with the sensor's pose among the landmarks of one version of the map.
struct PosedScan {
  LaserScan scan;
  Pose2 T_map_laser;
  std::uint64_t map_version = 0;
  /// Deviations of the pose relative to the landmarks around, not to the origin of map: what all of
  /// them have in common does no harm (paper, III).
  double pose_deviation_m = 0.0;
  double heading_deviation_rad = 0.0;
};

/// What became of an input. `accepted` false: nothing changed, and `reason` says why.
struct MapOutcome {
  bool accepted = false;
  std::string reason;
  PartitionChange change;  ///< of a landmark map or update
};

/// A layer of an LTR that was written.
struct ChangedLayer {
  int ltr = kNone;
  int layer = 0;
  std::uint64_t revision = 0;
};

/// Answer to a query at a place.
struct LayerQuery {
  enum class Status { kKnown, kUnknown, kOutside, kNoSuchLayer };
  Status status = Status::kUnknown;
  int ltr = kNone;
  std::optional<LayerValue> value;
};

/// Hybrid metric map (paper, III): dense layers inside local triangular regions, which landmarks
/// span. When landmarks move, everything dense moves along without a cell being touched. The engine
/// of the node `hymm_grid`. Deterministic; not thread-safe.
///
///   HybridMap map(config);
///   map.apply(landmarks);              // corrects and grows the partition
///   map.insert(posed_scan);            // writes occupancy
///   map.insert(property_sample);       // writes another layer
///   map.query("occupancy", place);
class HybridMap {
 public:
  /// Counts since construction.
  struct Counts {
    std::size_t landmark_maps = 0, landmark_updates = 0, refused_landmarks = 0;
    std::size_t scans = 0, refused_scans = 0, beams = 0;
    std::size_t samples = 0, refused_samples = 0;
    std::size_t moving_objects = 0;  ///< squares of the traffic layer, by period
    std::size_t ltrs_created = 0, ltrs_retired = 0;
    // Observations lost for want of memory:
    std::size_t dropped_waiting_tiles = 0;
    std::size_t forgotten_ltrs = 0;
  };

  /// Throws ConfigError if the configuration is unusable.
  explicit HybridMap(const HybridMapConfig& config);
  ~HybridMap();
  HybridMap(HybridMap&&) noexcept;
  HybridMap& operator=(HybridMap&&) noexcept;

  /// All landmarks of an epoch. Of a map older than the version held, only the covariances are
  /// used, to grow by. After a reset of the filter, reset().
  MapOutcome apply(const LandmarkMap& map);
  /// What changed since a version that is not later than the one held.
  MapOutcome apply(const LandmarkUpdate& update);

  /// Writes the beams of a scan whose pose belongs to the version held.
  MapOutcome insert(const PosedScan& scan);
  MapOutcome insert(const PropertySample& sample);

  /// An empty map.
  void reset();

  /// Version of the landmarks held.
  std::uint64_t landmarkVersion() const;
  /// Grows with every accepted input.
  std::uint64_t revision() const;

  /// Landmarks that must not be dropped, because they span LTRs; ascending.
  std::vector<int> pinnedLandmarks() const;

  /// All LTRs, by ascending id, with the shape factors that the covariances of `map` give.
  std::vector<LtrTopology> topology(const LandmarkMap& map) const;
  /// Layers written after a revision, by LTR and layer.
  std::vector<ChangedLayer> changedSince(std::uint64_t revision) const;
  /// The cells of an LTR; null if there is none of this id.
  const LtrCells* cells(int ltr) const;

  const LayerSet& layers() const;
  LayerQuery query(const std::string& layer, const Eigen::Vector2d& place) const;

  /// Occupancy at a place as log-odds (1); 0 where nothing is known, or no LTR is.
  float occupancyLogOdds(const Eigen::Vector2d& place) const;
  /// Largest side of a cell when its LTR is made.
  double resolution_m() const;

  /// Occupancy as log-odds in square cells over the box from `low`, row by row along x; NaN where
  /// nothing is known.
  std::vector<float> renderOccupancy(const Eigen::Vector2d& low, int width, int height,
                                     double resolution_m) const;

  /// Evidence (see CellModel) of a layer in all LTRs, and in what waits for one.
  double evidenceInLtrs(int layer) const;
  double evidenceWaiting(int layer) const;

  /// Memory of the cells of all LTRs, and of what waits for one. Those beyond active_radius_m of
  /// the vehicle that were not written lately are compressed, and unpacked where they are looked at
  /// or written again. Where all LTRs together need more than max_memory_mb, those beyond that were
  /// not written for longest are emptied, and counted.
  CellMemory ltrMemory() const;
  CellMemory waitingMemory() const;

  /// The whole map as bytes: LTRs with all layers, and what waits for one.
  std::string saveState() const;
  /// The map that saveState() gave, in the place of the present one; its landmarks are those of
  /// `landmark_version`. `name` leads the sentences of what is thrown: InputError, and nothing
  /// changed, if the bytes are damaged or do not suit the configuration.
  void loadState(std::string_view bytes, const std::string& name, std::uint64_t landmark_version);
  /// Throws what loadState() would.
  void checkState(std::string_view bytes, const std::string& name) const;

  const LtrPartition& partition() const;
  const WaitingTiles& waiting() const;
  const Counts& counts() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hymm::core
