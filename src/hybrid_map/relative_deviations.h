#pragma once

#include <array>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include <Eigen/Core>

#include "cekf/landmark_map.h"
#include "hybrid_map/pair_covariances.h"

namespace hymm::core {

/// How well landmarks of one epoch are known relative to each other.
class RelativeDeviations {
 public:
  /// Of the landmarks `ids`; `map` outlives the object.
  RelativeDeviations(const LandmarkMap& map, const std::unordered_set<int>& ids);

  /// Of one landmark's place relative to another's [m], in the direction in which it is largest.
  /// Where the map does not tell their covariance, since they are far apart: as if they were
  /// independent, were it known where the landmarks between them are. Where none are between, or
  /// all so near to each other that they tell no direction, the most that it can be. Infinite for
  /// unknown landmarks.
  double between(int one, int other) const;

  /// Of any of the one relative to any of the other. None is more than that of the one relative to
  /// a third of them and of this one relative to the other.
  double largest(const std::array<int, 2>& ones, const std::array<int, 2>& others) const;

 private:
  using Matrix2 = Eigen::Matrix2d;

  std::vector<int> landmarksBetween(int one, int other) const;
  std::optional<Matrix2> blockThrough(const std::vector<int>& between, int one, int other) const;

  std::unordered_map<int, const LandmarkEstimate*> landmarks_;
  std::unordered_map<int, std::vector<int>> told_with_;  ///< of `ids`; ascending
  std::optional<PairCovariances> pairs_;
};

}  // namespace hymm::core
