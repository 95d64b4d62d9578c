#include "information_map/landmark_field.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace hymm::core {
namespace {

// The index never has more cells than this many a landmark: a stray landmark far away must not make
// it huge.
constexpr double kCellsPerLandmark = 64.0;

// A map may be exact in a direction, or in all of them: singular covariances are welcome.
bool isUsable(const LandmarkEstimate& landmark) {
  constexpr double kRounding = 1e-6;  // of a message that went through float or text
  const Eigen::Matrix2d& P = landmark.covariance;
  const double scale = P.cwiseAbs().maxCoeff();
  return landmark.position.allFinite() && P.allFinite() && P(0, 0) >= 0.0 && P(1, 1) >= 0.0 &&
         std::abs(P(0, 1) - P(1, 0)) <= kRounding * scale &&
         P.determinant() >= -kRounding * scale * scale;
}

}  // namespace

LandmarkField::LandmarkField(const LandmarkMap& map, double cell_m)
    : version_(map.version), time_s_(map.time_s) {
  takeLandmarks(map);
  takePairs(map);
  buildIndex(cell_m);
}

void LandmarkField::takeLandmarks(const LandmarkMap& map) {
  for (const LandmarkEstimate& landmark : map.landmarks) {
    if (!isUsable(landmark) || index_of_id_.count(landmark.id) != 0) {
      ++refused_landmarks_;
      continue;
    }
    index_of_id_[landmark.id] = size();
    ids_.push_back(landmark.id);
    positions_.push_back(landmark.position);
    covariances_.push_back(0.5 * (landmark.covariance + landmark.covariance.transpose()));
  }
}

void LandmarkField::takePairs(const LandmarkMap& map) {
  struct Entry {
    int first = -1;
    Pair pair;
  };
  std::vector<Entry> entries;
  entries.reserve(map.cross_covariances.size());
  for (const CrossCovariance& cross : map.cross_covariances) {
    const int first = indexOf(cross.first_id), second = indexOf(cross.second_id);
    if (first < 0 || second < 0 || first == second || !cross.block.allFinite()) {
      ++refused_pairs_;
    } else if (first < second) {
      entries.push_back({first, {second, cross.block}});
    } else {
      entries.push_back({second, {first, cross.block.transpose()}});
    }
  }
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.first != b.first ? a.first < b.first : a.pair.second < b.pair.second;
  });
  first_pair_.assign(ids_.size() + 1, 0);
  pairs_.reserve(entries.size());
  int last_first = -1;
  for (const Entry& entry : entries) {
    if (entry.first == last_first && pairs_.back().second == entry.pair.second) {
      ++refused_pairs_;
      continue;
    }
    last_first = entry.first;
    pairs_.push_back(entry.pair);
    ++first_pair_[std::size_t(entry.first) + 1];
  }
  for (std::size_t i = 1; i < first_pair_.size(); ++i) first_pair_[i] += first_pair_[i - 1];
}

void LandmarkField::buildIndex(double cell_m) {
  if (positions_.empty()) return;
  low_ = high_ = positions_.front();
  for (const Eigen::Vector2d& position : positions_) {
    low_ = low_.cwiseMin(position);
    high_ = high_.cwiseMax(position);
  }
  const Eigen::Vector2d extent = high_ - low_;
  const double most = kCellsPerLandmark * static_cast<double>(size());
  cell_m_ = std::max({cell_m, extent.maxCoeff() / most, std::sqrt(extent.prod() / most)});
  columns_ = static_cast<std::int32_t>(extent.x() / cell_m_) + 1;
  rows_ = static_cast<std::int32_t>(extent.y() / cell_m_) + 1;

  const auto cellIndex = [this](const Eigen::Vector2d& position) {
    const Eigen::Vector2i cell = cellOf(position.array());
    return std::size_t(cell.y()) * std::size_t(columns_) + std::size_t(cell.x());
  };
  first_of_cell_.assign(std::size_t(columns_) * std::size_t(rows_) + 1, 0);
  for (const Eigen::Vector2d& position : positions_) ++first_of_cell_[cellIndex(position) + 1];
  for (std::size_t i = 1; i < first_of_cell_.size(); ++i)
    first_of_cell_[i] += first_of_cell_[i - 1];
  cells_.resize(positions_.size());
  std::vector<int> next(first_of_cell_.begin(), first_of_cell_.end() - 1);
  for (int i = 0; i < size(); ++i) cells_[std::size_t(next[cellIndex(position(i))]++)] = i;
}

Eigen::Vector2i LandmarkField::cellOf(const Eigen::Array2d& place) const {
  // Clamped before the cast: places far outside must not overflow.
  const Eigen::Array2d cell = ((place - low_.array()) / cell_m_).floor();
  const Eigen::Array2d limit(columns_, rows_);
  return cell.max(-1.0).min(limit).matrix().cast<int>();
}

int LandmarkField::indexOf(int id) const {
  const auto found = index_of_id_.find(id);
  return found == index_of_id_.end() ? -1 : found->second;
}

}  // namespace hymm::core
