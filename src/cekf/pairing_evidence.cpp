#include "cekf/pairing_evidence.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include <Eigen/Cholesky>

#include "cekf/joint_factor.h"
#include "common/angles.h"

namespace hymm::core {
namespace {

/// What a pairing's odds are without its innovation.
double oddsBeforeMeasuring(const Pairing& pairing) {
  return -0.5 * pairing.cue_cost - std::log(2.0 * kPi * pairing.chance_density);
}

/// What a pairing adds to the log odds of those at the places before it.
double gain(std::size_t place, int pairing, const std::vector<Pairing>& pairings,
            JointFactor& factor) {
  const JointFactor::Addition added = factor.put(place, pairing);
  return oddsBeforeMeasuring(pairings[static_cast<std::size_t>(pairing)]) - 0.5 * added.distance2 -
         added.log_deviations;
}

std::vector<int> pairedBy(const std::vector<int>& hypothesis) {
  std::vector<int> paired;
  std::copy_if(hypothesis.begin(), hypothesis.end(), std::back_inserter(paired),
               [](int pairing) { return pairing >= 0; });
  return paired;
}

}  // namespace

double logOdds(const Pairing& pairing, const Eigen::Matrix2d& S) {
  const Eigen::LLT<Eigen::Matrix2d> factor(S);
  if (factor.info() != Eigen::Success) return -std::numeric_limits<double>::infinity();
  const Eigen::Vector2d whitened = factor.matrixL().solve(pairing.innovation);
  return oddsBeforeMeasuring(pairing) - 0.5 * whitened.squaredNorm() -
         factor.matrixLLT().diagonal().array().log().sum();
}

double logOdds(const std::vector<int>& chosen, const std::vector<Pairing>& pairings,
               const Eigen::MatrixXd& S) {
  JointFactor factor(pairings, S, chosen.size());
  double log_odds = 0.0;
  for (std::size_t place = 0; place < chosen.size(); ++place) {
    log_odds += gain(place, chosen[place], pairings, factor);
  }
  return log_odds;
}

std::vector<int> undisputedPairings(const JointCompatibility& joint, std::vector<int> hypothesis,
                                    const std::vector<Pairing>& pairings, const Eigen::MatrixXd& S,
                                    double least_log_odds) {
  // A rival may explain one observation less.
  const double within = joint.limits().unpaired_cost + 2.0 * least_log_odds;
  for (std::vector<int> paired = pairedBy(hypothesis);; paired = pairedBy(hypothesis)) {
    if (paired.empty()) return paired;
    const JointHypothesis rival = joint.findRival(pairings, S, hypothesis, within);
    if (rival.pairings.empty()) return paired;
    const double ahead =
        logOdds(paired, pairings, S) - logOdds(pairedBy(rival.pairings), pairings, S);
    if (ahead >= least_log_odds) return paired;
    for (std::size_t k = 0; k < hypothesis.size(); ++k) {
      if (hypothesis[k] != rival.pairings[k]) hypothesis[k] = -1;
    }
  }
}

std::vector<int> provenPairings(const std::vector<int>& chosen,
                                const std::vector<Pairing>& pairings, const Eigen::MatrixXd& S,
                                double least_log_odds) {
  JointFactor factor(pairings, S, chosen.size());
  std::vector<int> proven, open = chosen;
  for (bool found = true; found;) {
    found = false;
    for (std::size_t i = 0; i < open.size();) {
      if (gain(proven.size(), open[i], pairings, factor) < least_log_odds) {
        ++i;
        continue;
      }
      proven.push_back(open[i]);
      open.erase(open.begin() + static_cast<std::ptrdiff_t>(i));
      found = true;
    }
  }
  double together = 0.0;
  for (std::size_t i = 0; i < open.size(); ++i) {
    together += gain(proven.size() + i, open[i], pairings, factor);
  }
  if (!open.empty() && together >= least_log_odds) {
    proven.insert(proven.end(), open.begin(), open.end());
  }
  std::sort(proven.begin(), proven.end());
  return proven;
}

}  // namespace hymm::core
