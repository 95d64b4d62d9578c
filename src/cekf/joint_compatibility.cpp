#include "cekf/joint_compatibility.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "cekf/hypothesis_without.h"
#include "cekf/joint_factor.h"
#include "common/chi_square.h"

namespace hymm::core {
namespace {

/// Depth-first search over observations.
class Search {
 public:
  Search(const std::vector<Pairing>& pairings, const Eigen::MatrixXd& S, int observations,
         const JointCompatibility& compatibility)
      : pairings_(pairings),
        S_(S),
        compatibility_(compatibility),
        limits_(compatibility.limits()),
        factor_(pairings, S, static_cast<std::size_t>(observations)) {
    by_observation_.resize(static_cast<std::size_t>(observations));
    for (std::size_t k = 0; k < pairings.size(); ++k) {
      by_observation_[static_cast<std::size_t>(pairings[k].observation)].push_back(
          static_cast<int>(k));
    }
    orderObservations();
    best_.pairings.assign(static_cast<std::size_t>(observations), -1);
    current_.assign(static_cast<std::size_t>(observations), -1);
  }

  JointHypothesis run() {
    best_cost_ = limits_.unpaired_cost * static_cast<double>(order_.size());
    chooseGreedily();
    descend(0, 0.0, 0.0);
    return best_;
  }

  /// See findRival().
  JointHypothesis runAgainst(const std::vector<int>& other, double within) {
    other_ = &other;
    best_.pairings.clear();
    // What may contradict comes first: where it is wrong, hardly anything else fits then.
    const auto agreeing = std::stable_partition(
        order_.begin(), order_.end(),
        [this](std::size_t observation) { return mayContradict(observation); });
    contradicts_before_ = static_cast<std::size_t>(agreeing - order_.begin());
    if (contradicts_before_ == 0) return best_;
    best_cost_ = costOf(other) + within;
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

  bool mayContradict(std::size_t observation) const {
    return (*other_)[observation] >= 0 && by_observation_[observation].size() > 1;
  }

  double costOf(const std::vector<int>& hypothesis) {
    double cost = 0.0;
    std::size_t place = 0;
    for (const std::size_t observation : order_) {
      const int pairing = hypothesis[observation];
      cost += pairing < 0 ? limits_.unpaired_cost
                          : factor_.put(place++, pairing).distance2 +
                                pairings_[static_cast<std::size_t>(pairing)].cue_cost;
    }
    return cost;
  }

  /// Whether no hypothesis that goes on from here contradicts the other one.
  bool agreesForGood(std::size_t depth) const {
    return other_ != nullptr && contradictions_ == 0 && depth >= contradicts_before_;
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
        choose(observation, pairing);
      } else {
        other_cost += limits_.unpaired_cost;
      }
    }
    keepIfBest(mahalanobis2, other_cost);
    // If leaving out one more pairing already costs more than the best, nothing else is needed.
    if (best_cost_ > limits_.unpaired_cost) notePlainPairings();
    chosen_.clear();
    current_.assign(current_.size(), -1);
  }

  void notePlainPairings() {
    std::vector<int> plain;
    std::copy_if(chosen_.begin(), chosen_.end(), std::back_inserter(plain), [this](int pairing) {
      const int observation = pairings_[static_cast<std::size_t>(pairing)].observation;
      return by_observation_[static_cast<std::size_t>(observation)].size() == 1;
    });
    if (!plain.empty()) plain_.emplace(pairings_, S_, plain);
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
    if (leastCost(mahalanobis2, other_cost) >= best_cost_ || agreesForGood(depth)) return;
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
      choose(observation, pairing);
      const bool contradicts =
          other_ != nullptr && mayContradict(observation) && (*other_)[observation] != pairing;
      contradictions_ += contradicts ? 1 : 0;
      descend(depth + 1, mahalanobis2 + increment,
              other_cost + pairings_[static_cast<std::size_t>(pairing)].cue_cost);
      contradictions_ -= contradicts ? 1 : 0;
      current_[observation] = -1;
      chosen_.pop_back();
    }
    const bool is_plain = plain_ && plain_->has(by_observation_[observation].front());
    if (is_plain) plain_->leaveOut(by_observation_[observation].front());
    descend(depth + 1, mahalanobis2, other_cost + limits_.unpaired_cost);
    if (is_plain) plain_->takeBack();
  }

  /// Below what no hypothesis costs that goes on from here. If it leaves out one more of the plain
  /// pairings, it pays for that; if not, it is at least as far off as those that are not left out.
  double leastCost(double mahalanobis2, double other_cost) const {
    if (!plain_) return mahalanobis2 + other_cost;
    return other_cost + std::min(std::max(mahalanobis2, plain_->distance2()),
                                 mahalanobis2 + limits_.unpaired_cost);
  }

  void choose(std::size_t observation, int pairing) {
    factor_.put(chosen_.size(), pairing);
    chosen_.push_back(pairing);
    current_[observation] = pairing;
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
      const double increment = factor_.put(chosen_.size(), k).distance2;
      if (std::isfinite(increment)) ranked.emplace_back(increment, k);
    }
    std::sort(ranked.begin(), ranked.end());
    return ranked;
  }

  const std::vector<Pairing>& pairings_;
  const Eigen::MatrixXd& S_;
  const JointCompatibility& compatibility_;
  const JointCompatibilityLimits& limits_;
  std::vector<std::vector<int>> by_observation_;
  std::vector<std::size_t> order_;  ///< observations that have candidates
  JointFactor factor_;              ///< of those chosen
  /// Pairings of the first hypothesis whose observations have no other candidate.
  std::optional<HypothesisWithout> plain_;
  std::vector<int> chosen_, current_;
  const std::vector<int>* other_ = nullptr;  ///< the hypothesis to contradict, if there is one
  int contradictions_ = 0;                   ///< of it by those chosen
  std::size_t contradicts_before_ = 0;       ///< depth from which on none is possible
  double effort_ = 0.0;                      ///< so far, in nodes
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

JointHypothesis JointCompatibility::findRival(const std::vector<Pairing>& pairings,
                                              const Eigen::MatrixXd& S,
                                              const std::vector<int>& other, double within) const {
  return Search(pairings, S, static_cast<int>(other.size()), *this).runAgainst(other, within);
}

double JointCompatibility::gate(int pairings) const {
  const auto k = static_cast<std::size_t>(pairings);
  return k < gates_.size() ? gates_[k] : chiSquareQuantile(limits_.joint_probability, 2 * pairings);
}

}  // namespace hymm::core
