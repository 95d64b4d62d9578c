#include "cekf/pairing_evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "common/angles.h"

namespace hymm::core {

double logOdds(const std::vector<int>& chosen, const std::vector<Pairing>& pairings,
               const Eigen::MatrixXd& S) {
  const auto n = static_cast<Eigen::Index>(chosen.size());
  Eigen::MatrixXd joint(2 * n, 2 * n);
  Eigen::VectorXd innovation(2 * n);
  double log_odds = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const int k = chosen[static_cast<std::size_t>(i)];
    const Pairing& pairing = pairings[static_cast<std::size_t>(k)];
    innovation.segment<2>(2 * i) = pairing.innovation;
    log_odds -= 0.5 * pairing.cue_cost + std::log(2.0 * kPi * pairing.chance_density);
    for (Eigen::Index j = 0; j < n; ++j) {
      joint.block<2, 2>(2 * i, 2 * j) =
          S.block<2, 2>(2 * k, 2 * chosen[static_cast<std::size_t>(j)]);
    }
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(joint);
  if (factor.info() != Eigen::Success) return -std::numeric_limits<double>::infinity();
  const Eigen::VectorXd whitened = factor.matrixL().solve(innovation);
  const Eigen::VectorXd deviations = factor.matrixLLT().diagonal();
  return log_odds - 0.5 * whitened.squaredNorm() - deviations.array().log().sum();
}

std::vector<int> provenPairings(const std::vector<int>& chosen,
                                const std::vector<Pairing>& pairings, const Eigen::MatrixXd& S,
                                double least_log_odds) {
  std::vector<int> proven, open = chosen;
  double proven_log_odds = 0.0;
  const auto gain = [&](const std::vector<int>& more) {
    std::vector<int> together = proven;
    together.insert(together.end(), more.begin(), more.end());
    return logOdds(together, pairings, S) - proven_log_odds;
  };
  for (bool found = true; found;) {
    found = false;
    for (std::size_t i = 0; i < open.size();) {
      const double log_odds = gain({open[i]});
      if (log_odds < least_log_odds) {
        ++i;
        continue;
      }
      proven.push_back(open[i]);
      proven_log_odds += log_odds;
      open.erase(open.begin() + static_cast<std::ptrdiff_t>(i));
      found = true;
    }
  }
  if (!open.empty() && gain(open) >= least_log_odds) {
    proven.insert(proven.end(), open.begin(), open.end());
  }
  std::sort(proven.begin(), proven.end());
  return proven;
}

}  // namespace hymm::core
