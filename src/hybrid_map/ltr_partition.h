#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "cekf/landmark_map.h"
#include "common/pose2.h"
#include "hybrid_map/ltr_mesh.h"
#include "hybrid_map/partition_config.h"

namespace hymm::core {

/// An LTR that was given up. Its data lie in `last_valid` coordinates; T_map_last_valid brings
/// points of that geometry to where they most likely are now.
struct RetiredLtr {
  enum class Reason { kShape, kOverlap, kVertexGone, kMerge };

  int ltr = kNone;
  Reason reason = Reason::kShape;
  Triangle last_valid;
  Pose2 T_map_last_valid;
};

/// What a change of the landmarks did to the partition.
struct PartitionChange {
  std::vector<int> created;  ///< LTRs
  std::vector<RetiredLtr> retired;
};

/// Cuts the landmark map into LTRs and keeps them valid. Invariants, whatever the landmarks do:
/// LTRs are counter-clockwise, share whole sides, and no two overlap. Holes are allowed, and
/// landmarks inside an LTR may be left out (Figure 3). An LTR keeps its identity until a correction
/// makes it invalid: turned over, stretched beyond the limit, or overlapping one with more
/// observations.
class LtrPartition {
 public:
  explicit LtrPartition(const PartitionConfig& config);

  /// All landmarks of an epoch: corrects every LTR, then grows by landmarks that can be vertices.
  PartitionChange apply(const LandmarkMap& map);

  /// Some landmarks: corrects their LTRs. An update carries no covariances of pairs, so nothing
  /// grows.
  PartitionChange apply(const LandmarkUpdate& update);

  /// Grows by landmarks that can be vertices, without correcting anything: places of vertices in
  /// `map` are those that the partition has.
  PartitionChange grow(const LandmarkMap& map);

  /// Evidence written into an LTR: where two overlap, the one with less goes.
  void addObservations(int ltr, double count) { mesh_.addObservations(ltr, count); }

  /// Landmarks that must not be dropped, because they span LTRs; ascending.
  std::vector<int> pinnedLandmarks() const { return mesh_.vertexLandmarks(); }

  const LtrMesh& mesh() const { return mesh_; }

  template <class Archive>
  void describeState(Archive& archive) {
    archive(mesh_, touched_, is_touched_, overlap_suspects_, gone_, epoch_, seen_epoch_,
            tried_observations_);
    if constexpr (Archive::kReads) {
      const bool fits = touched_.empty() && isBelow(overlap_suspects_, mesh_.ltrEnd()) &&
                        is_touched_.size() <= std::size_t(mesh_.ltrEnd()) &&
                        seen_epoch_.size() <= std::size_t(mesh_.vertexEnd());
      archive.require(fits, "its triangles are fewer than it tells of");
    }
  }

 private:
  static bool isBelow(const std::vector<int>& ltrs, int end);

  void mergeVertices(const std::vector<LandmarkMerge>& merges,
                     const std::vector<LandmarkEstimate>& landmarks, PartitionChange& change);
  void moveVertices(const std::vector<LandmarkEstimate>& landmarks);
  void loseVertex(int vertex);
  void loseUnseenVertices();
  void touch(int vertex);
  void correct(PartitionChange& change);
  void retireMisshapen(PartitionChange& change);
  void retireOverlapping(PartitionChange& change);
  int overlappingNeighbour(int ltr) const;
  void retire(int ltr, RetiredLtr::Reason reason, PartitionChange& change);
  bool isWorthTrying(const LandmarkEstimate& landmark) const;

  PartitionConfig config_;
  LtrMesh mesh_;
  std::vector<int> touched_;           ///< LTRs to check in this epoch, each once
  std::vector<bool> is_touched_;       ///< by LTR
  std::vector<int> overlap_suspects_;  ///< on the rim, to be checked for overlaps
  std::unordered_set<int> gone_;       ///< vertices whose landmarks the filter dropped
  std::uint64_t epoch_ = 0;
  std::vector<std::uint64_t> seen_epoch_;            ///< by vertex: when its landmark was told last
  std::unordered_map<int, int> tried_observations_;  ///< of landmarks, when growth last tried them
};

}  // namespace hymm::core
