#include "hybrid_map/relative_deviations.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace hymm::core {
namespace {

// Landmarks nearer to each other than this tell where others are, but not in which direction; more
// than so many tell no more.
constexpr double kLeastSpread_m = 10.0;
constexpr std::size_t kMostBetween = 4;

// Of the covariance of landmarks between: below, what comes of it is rounding.
constexpr double kLeastCondition = 1e-9;

double largestDeviation(const Eigen::Matrix2d& covariance) {
  if (!covariance.allFinite()) return std::numeric_limits<double>::infinity();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, axes.eigenvalues()[1]));
}

}  // namespace

RelativeDeviations::RelativeDeviations(const LandmarkMap& map, const std::unordered_set<int>& ids) {
  for (const LandmarkEstimate& landmark : map.landmarks) landmarks_[landmark.id] = &landmark;
  std::unordered_set<int> needed = ids;  // and those beside them
  const auto note = [&](int one, int other) {
    if (ids.count(one) == 0) return;
    told_with_[one].push_back(other);
    needed.insert(other);
  };
  for (const CrossCovariance& pair : map.cross_covariances) {
    if (landmarks_.count(pair.first_id) == 0 || landmarks_.count(pair.second_id) == 0) continue;
    note(pair.first_id, pair.second_id);
    note(pair.second_id, pair.first_id);
  }
  for (auto& [id, others] : told_with_) std::sort(others.begin(), others.end());
  pairs_.emplace(map, needed);
}

double RelativeDeviations::between(int one, int other) const {
  const auto a = landmarks_.find(one), b = landmarks_.find(other);
  if (a == landmarks_.end() || b == landmarks_.end()) {
    return std::numeric_limits<double>::infinity();
  }
  if (one == other) return 0.0;
  const Matrix2 &P_a = a->second->covariance, &P_b = b->second->covariance;
  auto P_ab = pairs_->block(one, other);
  if (!P_ab) P_ab = blockThrough(landmarksBetween(one, other), one, other);
  const double most = largestDeviation(P_a) + largestDeviation(P_b);
  return P_ab ? std::min(most, largestDeviation(P_a + P_b - *P_ab - P_ab->transpose())) : most;
}

double RelativeDeviations::largest(const std::array<int, 2>& ones,
                                   const std::array<int, 2>& others) const {
  const std::array<int, 4> all = {ones[0], ones[1], others[0], others[1]};
  Eigen::Matrix4d deviations = Eigen::Matrix4d::Zero();
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < i; ++j) {
      deviations(i, j) = deviations(j, i) = between(all[std::size_t(i)], all[std::size_t(j)]);
    }
  }
  for (int through = 0; through < 4; ++through) {
    const Eigen::Vector4d from = deviations.col(through);
    deviations =
        deviations.cwiseMin(from.replicate<1, 4>() + from.transpose().replicate<4, 1>()).eval();
  }
  return deviations.topRightCorner<2, 2>().maxCoeff();
}

/// Those nearest to halfway whose covariances with both, and with each other, are told; none if
/// they tell no direction.
std::vector<int> RelativeDeviations::landmarksBetween(int one, int other) const {
  const auto with_one = told_with_.find(one), with_other = told_with_.find(other);
  if (with_one == told_with_.end() || with_other == told_with_.end()) return {};
  std::vector<int> common;
  std::set_intersection(with_one->second.begin(), with_one->second.end(),
                        with_other->second.begin(), with_other->second.end(),
                        std::back_inserter(common));
  const auto place = [this](int id) { return landmarks_.at(id)->position; };
  const Eigen::Vector2d halfway = 0.5 * (place(one) + place(other));
  std::vector<std::pair<double, int>> by_distance;
  for (const int id : common) by_distance.emplace_back((place(id) - halfway).norm(), id);
  std::sort(by_distance.begin(), by_distance.end());
  std::vector<int> between;
  bool has_spread = false;
  for (const auto& [distance_m, id] : by_distance) {
    const bool is_told = std::all_of(between.begin(), between.end(), [&, id = id](int with) {
      return pairs_->block(id, with).has_value();
    });
    if (!is_told) continue;
    const bool is_apart = std::any_of(between.begin(), between.end(), [&, id = id](int with) {
      return (place(id) - place(with)).norm() >= kLeastSpread_m;
    });
    has_spread = has_spread || is_apart;
    // The last place is kept for one that is apart from the others.
    if (between.size() + 1 < kMostBetween || has_spread) between.push_back(id);
    if (between.size() == kMostBetween) break;
  }
  return has_spread ? between : std::vector<int>();
}

std::optional<Eigen::Matrix2d> RelativeDeviations::blockThrough(const std::vector<int>& between,
                                                                int one, int other) const {
  if (between.empty()) return std::nullopt;
  const auto n = 2 * static_cast<Eigen::Index>(between.size());
  Eigen::MatrixXd P(n, n), P_one(2, n), P_other(2, n);
  for (Eigen::Index i = 0; i < n / 2; ++i) {
    const int id = between[std::size_t(i)];
    P_one.middleCols<2>(2 * i) = *pairs_->block(one, id);
    P_other.middleCols<2>(2 * i) = *pairs_->block(other, id);
    P.block<2, 2>(2 * i, 2 * i) = landmarks_.at(id)->covariance;
    for (Eigen::Index j = 0; j < i; ++j) {
      const Matrix2 block = *pairs_->block(id, between[std::size_t(j)]);
      P.block<2, 2>(2 * i, 2 * j) = block;
      P.block<2, 2>(2 * j, 2 * i) = block.transpose();
    }
  }
  const Eigen::LLT<Eigen::MatrixXd> root(P);
  const bool is_usable =
      P.allFinite() && root.info() == Eigen::Success && root.rcond() > kLeastCondition;
  if (!is_usable) return std::nullopt;
  return Matrix2(P_one * root.solve(P_other.transpose()));
}

}  // namespace hymm::core
