#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "cekf/landmark_map.h"

namespace hymm::core {

/// One version of the landmark map, laid out for fast questions: which landmarks are near a place,
/// and what is the covariance of two of them. Landmarks are named by their index, which is their
/// place in the map that the field was made from, less those refused. Immutable.
class LandmarkField {
 public:
  /// Covariance of a landmark with one of a higher index; rows are of the lower one.
  struct Pair {
    int second = -1;
    Eigen::Matrix2d block = Eigen::Matrix2d::Zero();  ///< m^2
  };

  LandmarkField() = default;

  /// Landmarks whose position or covariance cannot be used are left out, and counted; so are pairs
  /// of landmarks that are not there. `cell_m`: of the index, best about the range of the queries.
  LandmarkField(const LandmarkMap& map, double cell_m);

  int size() const { return static_cast<int>(ids_.size()); }
  int id(int index) const { return ids_[std::size_t(index)]; }
  const Eigen::Vector2d& position(int index) const { return positions_[std::size_t(index)]; }
  const Eigen::Matrix2d& covariance(int index) const { return covariances_[std::size_t(index)]; }
  /// -1 if there is none of this id.
  int indexOf(int id) const;

  /// All pairs of a landmark with those of higher index, ascending.
  const Pair* pairsBegin(int index) const {
    return pairs_.data() + first_pair_[std::size_t(index)];
  }
  const Pair* pairsEnd(int index) const {
    return pairs_.data() + first_pair_[std::size_t(index) + 1];
  }

  /// Calls `visit(index)` for each landmark within `range_m` of a place, in an order that depends
  /// on the landmarks only.
  template <class Visitor>
  void visitNear(const Eigen::Vector2d& place, double range_m, Visitor&& visit) const {
    if (cells_.empty()) return;
    const auto low = cellOf(place.array() - range_m), high = cellOf(place.array() + range_m);
    for (std::int32_t y = std::max(low.y(), 0); y <= std::min(high.y(), rows_ - 1); ++y) {
      for (std::int32_t x = std::max(low.x(), 0); x <= std::min(high.x(), columns_ - 1); ++x) {
        const std::size_t cell = std::size_t(y) * std::size_t(columns_) + std::size_t(x);
        for (int k = first_of_cell_[cell]; k < first_of_cell_[cell + 1]; ++k) {
          const int index = cells_[std::size_t(k)];
          if ((position(index) - place).squaredNorm() <= range_m * range_m) visit(index);
        }
      }
    }
  }

  /// Box around all landmarks [m]; both corners zero if there are none.
  const Eigen::Vector2d& low() const { return low_; }
  const Eigen::Vector2d& high() const { return high_; }

  std::uint64_t version() const { return version_; }
  double time_s() const { return time_s_; }
  std::size_t refusedLandmarks() const { return refused_landmarks_; }
  std::size_t refusedPairs() const { return refused_pairs_; }

 private:
  Eigen::Vector2i cellOf(const Eigen::Array2d& place) const;
  void takeLandmarks(const LandmarkMap& map);
  void takePairs(const LandmarkMap& map);
  void buildIndex(double cell_m);

  std::uint64_t version_ = 0;
  double time_s_ = 0.0;
  std::vector<int> ids_;
  std::vector<Eigen::Vector2d> positions_;
  std::vector<Eigen::Matrix2d> covariances_;
  std::unordered_map<int, int> index_of_id_;
  std::vector<Pair> pairs_;                 ///< by first landmark, then by second
  std::vector<std::size_t> first_pair_{0};  ///< of each landmark in pairs_, and the end
  Eigen::Vector2d low_ = Eigen::Vector2d::Zero(), high_ = Eigen::Vector2d::Zero();
  double cell_m_ = 1.0;
  std::int32_t columns_ = 0, rows_ = 0;
  std::vector<int> first_of_cell_;  ///< of each cell in cells_, and the end
  std::vector<int> cells_;          ///< landmarks by cell
  std::size_t refused_landmarks_ = 0, refused_pairs_ = 0;
};

}  // namespace hymm::core
