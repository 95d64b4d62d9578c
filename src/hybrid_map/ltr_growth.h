#pragma once

#include <array>
#include <optional>
#include <unordered_map>
#include <vector>

#include "cekf/landmark_index.h"
#include "cekf/landmark_map.h"
#include "hybrid_map/ltr_mesh.h"
#include "hybrid_map/pair_covariances.h"
#include "hybrid_map/partition_config.h"

namespace hymm::core {

/// Adds LTRs to a mesh over the landmarks of one epoch. What is there stays; new LTRs lie outside
/// it and share whole sides with it.
class LtrGrowth {
 public:
  /// `map` and `mesh` outlive the object.
  LtrGrowth(const PartitionConfig& config, const LandmarkMap& map, LtrMesh& mesh);

  /// Adds LTRs that have one of `seeds` (indices into the map's landmarks) as a vertex. Of all that
  /// could be made, those come first whose circumcircles are empty of other landmarks (Delaunay),
  /// and then those with the larger smallest angle; thin ones come last. Where landmarks stand
  /// closer than sides may be, only some that stand apart are used. Returns the new LTRs.
  std::vector<int> growAround(const std::vector<int>& seeds);

 private:
  struct Candidate {
    std::array<int, 3> landmarks;  ///< indices into the map, counter-clockwise, the least one first
    bool is_thin;                  ///< may only fill a gap
    int landmarks_in_circle;
    double smallest_angle_rad;

    bool operator<(const Candidate& other) const;
  };

  /// By index into the map's landmarks.
  using Subset = std::vector<bool>;

  bool canSpan(int landmark) const;
  Subset standingApart(const std::vector<int>& seeds) const;
  std::vector<int> neighboursOf(int seed, const Subset& subset) const;
  void addCandidates(int seed, const std::vector<int>& neighbours,
                     std::vector<Candidate>& candidates) const;
  std::optional<Candidate> candidateOf(const std::array<int, 3>& landmarks,
                                       const std::vector<int>& neighbours) const;
  Corners cornersOf(const std::array<int, 3>& landmarks) const;
  bool fits(const Candidate& candidate) const;
  int sharedSides(const std::array<int, 3>& vertices) const;
  bool keepsClear(const Corners& corners, const std::array<int, 3>& vertices, int other) const;
  bool shapeIsKnown(const std::array<int, 3>& landmarks, const PairCovariances& pairs) const;
  int attach(std::array<int, 3> landmarks);

  const PartitionConfig& config_;
  const LandmarkMap& map_;
  LtrMesh& mesh_;
  LandmarkIndex index_;  ///< of landmarks that can be vertices
};

}  // namespace hymm::core
