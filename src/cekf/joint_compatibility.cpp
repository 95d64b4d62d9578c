#include "cekf/joint_compatibility.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/chi_square.h"

namespace hymm::core {
namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::Vector2d;

/// Depth-first search over observations; the Cholesky factor of the joint innovation covariance
/// grows and shrinks by one block row with the hypothesis.
class Search {
 public:
  Search(const std::vector<Pairing>& pairings, const Eigen::MatrixXd& S, int observations,
         const JointCompatibility& compatibility)
      : pairings_(pairings), S_(S), compatibility_(compatibility), limits_(compatibility.limits()) {
    by_observation_.resize(static_cast<std::size_t>(observations));
    for (std::size_t k = 0; k < pairings.size(); ++k) {
      by_observation_[static_cast<std::size_t>(pairings[k].observation)].push_back(
          static_cast<int>(k));
    }
    orderObservations();
    const auto depth = static_cast<Index>(order_.size());
    L_.setZero(2 * depth, 2 * depth);
    y_.setZero(2 * depth);
    best_.pairings.assign(static_cast<std::size_t>(observations), -1);
    current_.assign(static_cast<std::size_t>(observations), -1);
  }

  JointHypothesis run() {
    best_cost_ = limits_.unpaired_cost * static_cast<double>(order_.size());
    chooseGreedily();
    descend(0, 0.0, 0.0);
    return best_;
  }

 private:
  /// Observations with the fewest candidates first: they fix the vehicle for the others.
  void orderObservations() {
    for (std::size_t k = 0; k < by_observation_.size(); ++k) {
      if (!by_observation_[k].empty()) order_.push_back(k);
    }
    std::stable_sort(order_.begin(), order_.end(), [this](std::size_t a, std::size_t b) {
      return by_observation_[a].size() < by_observation_[b].size();
    });
  }

  /// A first hypothesis: each observation takes what adds least, as long as all stays compatible.
  /// It prunes the search, and is there if the search reaches its bound before it has any.
  void chooseGreedily() {
    double mahalanobis2 = 0.0, other_cost = 0.0;
    for (const std::size_t observation : order_) {
      const auto ranked = rankedCandidates(observation);
      const double gate = compatibility_.gate(static_cast<int>(chosen_.size()) + 1);
      const bool takes = !ranked.empty() && ranked.front().first < limits_.unpaired_cost &&
                         mahalanobis2 + ranked.front().first <= gate;
      if (takes) {
        mahalanobis2 += ranked.front().first;
        const int pairing = ranked.front().second;
        other_cost += pairings_[static_cast<std::size_t>(pairing)].cue_cost;
        appendToFactor(pairing);
        chosen_.push_back(pairing);
        current_[observation] = pairing;
      } else {
        other_cost += limits_.unpaired_cost;
      }
    }
    keepIfBest(mahalanobis2, other_cost);
    chosen_.clear();
    current_.assign(current_.size(), -1);
  }

  void keepIfBest(double mahalanobis2, double other_cost) {
    if (mahalanobis2 + other_cost >= best_cost_) return;
    if (mahalanobis2 > compatibility_.gate(static_cast<int>(chosen_.size()))) return;
    best_cost_ = mahalanobis2 + other_cost;
    best_.pairings = current_;
    best_.mahalanobis2 = mahalanobis2;
    best_.paired = static_cast<int>(chosen_.size());
  }

  void descend(std::size_t depth, double mahalanobis2, double other_cost) {
    if (mahalanobis2 + other_cost >= best_cost_) return;
    if (depth == order_.size()) return keepIfBest(mahalanobis2, other_cost);
    effort_ += nodeEffort();
    if (effort_ > limits_.max_nodes) {
      best_.complete = false;
      return;
    }
    const std::size_t observation = order_[depth];
    const auto most_pairings = static_cast<int>(chosen_.size() + order_.size() - depth);
    const double widest_gate = compatibility_.gate(most_pairings);
    for (const auto& [increment, pairing] : rankedCandidates(observation)) {
      if (mahalanobis2 + increment > widest_gate) break;
      appendToFactor(pairing);
      chosen_.push_back(pairing);
      current_[observation] = pairing;
      descend(depth + 1, mahalanobis2 + increment,
              other_cost + pairings_[static_cast<std::size_t>(pairing)].cue_cost);
      current_[observation] = -1;
      chosen_.pop_back();
    }
    descend(depth + 1, mahalanobis2, other_cost + limits_.unpaired_cost);
  }

  /// A node's work grows with the square of the pairings it carries: in nodes of usual scans.
  double nodeEffort() const {
    constexpr double kUsualPairings = 16.0;
    const double share = static_cast<double>(chosen_.size()) / kUsualPairings;
    return 1.0 + share * share;
  }

  /// Candidates whose landmark is free, by how much each adds to the joint distance.
  std::vector<std::pair<double, int>> rankedCandidates(std::size_t observation) {
    std::vector<std::pair<double, int>> ranked;
    for (const int k : by_observation_[observation]) {
      const int landmark = pairings_[static_cast<std::size_t>(k)].landmark;
      const bool taken = std::any_of(chosen_.begin(), chosen_.end(), [&](int other) {
        return pairings_[static_cast<std::size_t>(other)].landmark == landmark;
      });
      if (taken) continue;
      const double increment = appendToFactor(k);
      if (std::isfinite(increment)) ranked.emplace_back(increment, k);
    }
    std::sort(ranked.begin(), ranked.end());
    return ranked;
  }

  /// Writes the block row of pairing `k` below the factor of those chosen; returns what it adds to
  /// the squared Mahalanobis distance, infinite if the covariance is not positive definite.
  double appendToFactor(int k) {
    const auto n = static_cast<Index>(2 * chosen_.size());
    for (std::size_t c = 0; c < chosen_.size(); ++c) {
      const auto column = static_cast<Index>(2 * c);
      Matrix2d block = S_.block<2, 2>(2 * k, 2 * chosen_[c]);
      block -= L_.block(n, 0, 2, column).lazyProduct(L_.block(column, 0, 2, column).transpose());
      const Matrix2d diagonal = L_.block<2, 2>(column, column);
      L_.block<2, 2>(n, column) =
          diagonal.triangularView<Eigen::Lower>().solve(block.transpose()).transpose();
    }
    Matrix2d own = S_.block<2, 2>(2 * k, 2 * k);
    own -= L_.block(n, 0, 2, n).lazyProduct(L_.block(n, 0, 2, n).transpose());
    const double l00 = std::sqrt(own(0, 0)), l10 = own(1, 0) / l00;
    const double l11 = std::sqrt(own(1, 1) - l10 * l10);
    if (!(l00 > 0.0) || !(l11 > 0.0)) return std::numeric_limits<double>::infinity();
    L_.block<2, 2>(n, n) << l00, 0.0, l10, l11;
    const Vector2d rest =
        pairings_[static_cast<std::size_t>(k)].innovation - L_.block(n, 0, 2, n) * y_.head(n);
    y_[n] = rest[0] / l00;
    y_[n + 1] = (rest[1] - l10 * y_[n]) / l11;
    return y_.segment<2>(n).squaredNorm();
  }

  const std::vector<Pairing>& pairings_;
  const Eigen::MatrixXd& S_;
  const JointCompatibility& compatibility_;
  const JointCompatibilityLimits& limits_;
  std::vector<std::vector<int>> by_observation_;
  std::vector<std::size_t> order_;  ///< observations that have candidates
  /// By rows, two of which each product reads. Products are lazy: they are too small to be packed.
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> L_;
  Eigen::VectorXd y_;  ///< L^-1 * innovations
  std::vector<int> chosen_, current_;
  double effort_ = 0.0;  ///< so far, in nodes
  double best_cost_ = 0.0;
  JointHypothesis best_;
};

}  // namespace

JointCompatibility::JointCompatibility(const JointCompatibilityLimits& limits) : limits_(limits) {
  constexpr int kUsualPairings = 64;
  for (int k = 0; k <= kUsualPairings; ++k) {
    gates_.push_back(k == 0 ? 0.0 : chiSquareQuantile(limits.joint_probability, 2 * k));
  }
}

JointHypothesis JointCompatibility::find(const std::vector<Pairing>& pairings,
                                         const Eigen::MatrixXd& S, int observations) const {
  return Search(pairings, S, observations, *this).run();
}

double JointCompatibility::gate(int pairings) const {
  const auto k = static_cast<std::size_t>(pairings);
  return k < gates_.size() ? gates_[k] : chiSquareQuantile(limits_.joint_probability, 2 * pairings);
}

}  // namespace hymm::core
