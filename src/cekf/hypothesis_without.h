#pragma once

#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "cekf/joint_factor.h"
#include "cekf/pairing.h"

namespace hymm::core {

/// Squared Mahalanobis distance of a hypothesis without some of its pairings U. With A = S^-1 and
/// y = A * innovations, leaving them out takes y_U' * A_UU^-1 * y_U from it, so each costs the
/// square of those left out before, however many stay.
class HypothesisWithout {
 public:
  /// `S`: innovation covariance of all `pairings`, 2x2 blocks in their order, whole. The hypothesis
  /// is of those at `chosen`, whose part of it has to be positive definite.
  HypothesisWithout(const std::vector<Pairing>& pairings, const Eigen::MatrixXd& S,
                    const std::vector<int>& chosen);
  HypothesisWithout(const HypothesisWithout&) = delete;
  HypothesisWithout& operator=(const HypothesisWithout&) = delete;

  bool has(int pairing) const { return place_of_.count(pairing) > 0; }
  /// Leaves a pairing of the hypothesis out, too.
  void leaveOut(int pairing);
  /// Takes the one back that was left out last.
  void takeBack() { distances2_.pop_back(); }

  /// Without those that are left out.
  double distance2() const { return distances2_.back(); }

 private:
  std::unordered_map<int, int> place_of_;  ///< in the hypothesis, by pairing
  std::vector<Pairing> weighted_;          ///< the hypothesis, with y in place of the innovations
  Eigen::MatrixXd A_;
  JointFactor left_out_;
  std::vector<double> distances2_;  ///< by the number left out
};

}  // namespace hymm::core
