#pragma once

#include <array>
#include <optional>
#include <unordered_map>
#include <unordered_set>

#include <Eigen/Core>

#include "cekf/landmark_map.h"

namespace hymm::core {

/// Joint covariances of the landmarks of one epoch, as far as it tells them.
class PairCovariances {
 public:
  /// Keeps the pairs among `ids`; `map` outlives the object.
  PairCovariances(const LandmarkMap& map, const std::unordered_set<int>& ids);

  /// The covariance between two landmarks [m^2]; nothing where it is not told.
  std::optional<Eigen::Matrix2d> block(int first_id, int second_id) const;

  /// Of three landmarks given by their places in the map [m^2]; nothing where a pair is not told.
  std::optional<Eigen::Matrix<double, 6, 6>> joint(const std::array<int, 3>& landmarks) const;

 private:
  static std::uint64_t keyOf(int first, int second) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(first)) << 32U |
           static_cast<std::uint32_t>(second);
  }
  const LandmarkMap& map_;
  std::unordered_map<std::uint64_t, const CrossCovariance*> pairs_;
};

}  // namespace hymm::core
