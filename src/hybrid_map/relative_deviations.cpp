#include "hybrid_map/relative_deviations.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace hymm::core {
namespace {

// One landmark tells where others are, but not in which direction; more than these tell no more.
constexpr std::size_t kLeastBetween = 2;
constexpr std::size_t kMostBetween = 4;

double largestDeviation(const Eigen::Matrix2d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, axes.eigenvalues()[1]));
}

}  // namespace

RelativeDeviations::RelativeDeviations(const LandmarkMap& map) : pairs_(map) {
  for (const LandmarkEstimate& landmark : map.landmarks) landmarks_[landmark.id] = &landmark;
  for (const CrossCovariance& pair : map.cross_covariances) {
    told_with_[pair.first_id].push_back(pair.second_id);
    told_with_[pair.second_id].push_back(pair.first_id);
  }
  for (auto& [id, others] : told_with_) std::sort(others.begin(), others.end());
}

double RelativeDeviations::between(int one, int other) const {
  const auto a = landmarks_.find(one), b = landmarks_.find(other);
  if (a == landmarks_.end() || b == landmarks_.end()) {
    return std::numeric_limits<double>::infinity();
  }
  if (one == other) return 0.0;
  const Matrix2 &P_a = a->second->covariance, &P_b = b->second->covariance;
  auto P_ab = pairs_.block(one, other);
  if (!P_ab) P_ab = blockThrough(landmarksBetween(one, other), one, other);
  if (!P_ab) return largestDeviation(P_a) + largestDeviation(P_b);
  return largestDeviation(P_a + P_b - *P_ab - P_ab->transpose());
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

/// Those nearest to halfway whose covariances with both, and with each other, are told.
std::vector<int> RelativeDeviations::landmarksBetween(int one, int other) const {
  const auto with_one = told_with_.find(one), with_other = told_with_.find(other);
  if (with_one == told_with_.end() || with_other == told_with_.end()) return {};
  std::vector<int> common;
  std::set_intersection(with_one->second.begin(), with_one->second.end(),
                        with_other->second.begin(), with_other->second.end(),
                        std::back_inserter(common));
  const auto place = [this](int id) { return landmarks_.at(id)->position; };
  const Eigen::Vector2d halfway = 0.5 * (place(one) + place(other));
  std::stable_sort(common.begin(), common.end(), [&](int a, int b) {
    return (place(a) - halfway).squaredNorm() < (place(b) - halfway).squaredNorm();
  });
  std::vector<int> between;
  for (const int id : common) {
    const bool is_told = std::all_of(between.begin(), between.end(),
                                     [&](int with) { return pairs_.block(id, with).has_value(); });
    if (is_told) between.push_back(id);
    if (between.size() == kMostBetween) break;
  }
  return between;
}

std::optional<Eigen::Matrix2d> RelativeDeviations::blockThrough(const std::vector<int>& between,
                                                                int one, int other) const {
  if (between.size() < kLeastBetween) return std::nullopt;
  const auto n = 2 * static_cast<Eigen::Index>(between.size());
  Eigen::MatrixXd P(n, n), P_one(2, n), P_other(2, n);
  for (Eigen::Index i = 0; i < n / 2; ++i) {
    const int id = between[std::size_t(i)];
    P_one.middleCols<2>(2 * i) = *pairs_.block(one, id);
    P_other.middleCols<2>(2 * i) = *pairs_.block(other, id);
    P.block<2, 2>(2 * i, 2 * i) = landmarks_.at(id)->covariance;
    for (Eigen::Index j = 0; j < i; ++j) {
      const Matrix2 block = *pairs_.block(id, between[std::size_t(j)]);
      P.block<2, 2>(2 * i, 2 * j) = block;
      P.block<2, 2>(2 * j, 2 * i) = block.transpose();
    }
  }
  const Eigen::LLT<Eigen::MatrixXd> root(P);
  if (root.info() != Eigen::Success) return std::nullopt;
  return Matrix2(P_one * root.solve(P_other.transpose()));
}

}  // namespace hymm::core
