#include "hybrid_map/pair_covariances.h"

namespace hymm::core {

PairCovariances::PairCovariances(const LandmarkMap& map, const std::unordered_set<int>& ids)
    : map_(map) {
  for (const CrossCovariance& pair : map.cross_covariances) {
    if (ids.count(pair.first_id) == 0 || ids.count(pair.second_id) == 0) continue;
    pairs_[keyOf(pair.first_id, pair.second_id)] = &pair;
  }
}

std::optional<Eigen::Matrix2d> PairCovariances::block(int first_id, int second_id) const {
  if (const auto pair = pairs_.find(keyOf(first_id, second_id)); pair != pairs_.end()) {
    return pair->second->block;
  }
  if (const auto pair = pairs_.find(keyOf(second_id, first_id)); pair != pairs_.end()) {
    return Eigen::Matrix2d(pair->second->block.transpose());
  }
  return std::nullopt;
}

std::optional<Eigen::Matrix<double, 6, 6>> PairCovariances::joint(
    const std::array<int, 3>& landmarks) const {
  Eigen::Matrix<double, 6, 6> joint;
  for (int i = 0; i < 3; ++i) {
    const LandmarkEstimate& first = map_.landmarks[std::size_t(landmarks[std::size_t(i)])];
    joint.block<2, 2>(2 * i, 2 * i) = first.covariance;
    for (int j = i + 1; j < 3; ++j) {
      const LandmarkEstimate& second = map_.landmarks[std::size_t(landmarks[std::size_t(j)])];
      const auto cross = block(first.id, second.id);
      if (!cross) return std::nullopt;
      joint.block<2, 2>(2 * i, 2 * j) = *cross;
      joint.block<2, 2>(2 * j, 2 * i) = cross->transpose();
    }
  }
  return joint;
}

}  // namespace hymm::core
