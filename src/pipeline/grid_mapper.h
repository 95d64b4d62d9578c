#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "cekf/cekf_slam.h"
#include "common/stamp_schedule.h"
#include "hybrid_map/hybrid_map.h"
#include "hybrid_map/scan_matcher.h"
#include "perception/laser_scan.h"
#include "pipeline/hymm_grid_config.h"

namespace hymm::core {

/// A scan and what the filter made of it, all of one version of the landmarks.
struct MappedScan {
  PoseEstimate pose;
  LandmarkUpdate update;                   ///< up to the pose's version
  std::shared_ptr<const LandmarkMap> map;  ///< of that version, where a whole one was made
  std::optional<LaserScan> scan;           ///< nothing where the robot's own detector is used
};

/// What became of a MappedScan.
struct MappedOutcome {
  bool follows = false;  ///< the map is at the pose's version; else changes in between are missing
  bool written = false;  ///< the scan was written
  std::string reason;    ///< why the map does not follow, or the scan was not written
  /// How well the scan agrees with what the map said before; once a second by stamps.
  std::optional<ScanAgreement> agreement;
  bool topology = false;  ///< LTRs were created or retired, or may have other shape factors
};

/// Keeps a HybridMap in step with the filter: what the node `hymm_grid` and the offline run do with
/// each scan. For each scan in order: landmarks first, then the scan with the pose of that very
/// version. Not thread-safe.
class GridMapper {
 public:
  /// Scans that were not written, by what was missing.
  struct Counts {
    std::size_t without_landmarks = 0;  ///< changes of the landmarks in between were missing
    std::size_t not_written = 0;        ///< refused by the map; see its reason
  };

  /// Throws ConfigError if the configuration is unusable.
  explicit GridMapper(const HymmGridConfig& config)
      : map_(config.map), matcher_(config.scan_matching), min_range_m_(config.min_range_m) {}

  MappedOutcome process(const MappedScan& step);

  /// A property measured by another sensor.
  MapOutcome insert(const PropertySample& sample);

  /// The filter began a new map.
  void reset();

  /// See HybridMap. A map that is only for localising keeps its LTRs and cells as they are, until
  /// reset().
  std::string saveState() const { return map_.saveState(); }
  void checkState(std::string_view bytes, const std::string& name) const {
    map_.checkState(bytes, name);
  }
  void loadState(std::string_view bytes, const std::string& name, std::uint64_t landmark_version,
                 MapUse use);

  const HybridMap& map() const { return map_; }
  const ScanMatcher& matcher() const { return matcher_; }
  /// A scan as it would be written from a pose.
  PosedScan posed(const LaserScan& scan, const PoseEstimate& pose) const;
  /// The last whole map of the landmarks, whose covariances tell the shape factors; null at first.
  const std::shared_ptr<const LandmarkMap>& landmarks() const { return landmarks_; }
  std::vector<LtrTopology> topology() const;
  const Counts& counts() const { return counts_; }
  double cpu_s() const { return cpu_s_; }

 private:
  MapOutcome follow(const MappedScan& step);
  MapOutcome followVersion(std::uint64_t version);
  MapOutcome insert(const PosedScan& scan);

  HybridMap map_;
  ScanMatcher matcher_;
  double min_range_m_;
  StampSchedule agreement_due_{1.0};
  std::shared_ptr<const LandmarkMap> landmarks_;
  MapUse use_ = MapUse::kExtend;
  Counts counts_;
  double cpu_s_ = 0.0;
};

/// The scan with its sensor's pose in the map, and the deviations of that pose relative to the
/// landmarks around, and with its motion during the scan. Ranges below `min_range_m` become no
/// measurement (NaN).
PosedScan posedScan(const LaserScan& scan, const PoseEstimate& pose, double min_range_m);

}  // namespace hymm::core
