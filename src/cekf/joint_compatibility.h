#pragma once

#include <vector>

#include <Eigen/Core>

#include "cekf/pairing.h"

namespace hymm::core {

struct JointCompatibilityLimits {
  double unpaired_cost = 9.21;  ///< what leaving an observation out costs, as squared deviations
  double joint_probability = 0.99;  ///< of the chi-square gate on the joint innovation
  int max_nodes =
      20000;  ///< of the search tree, larger ones counted more; then the best is returned
};

/// A set of pairings, at most one for each observation and each landmark.
struct JointHypothesis {
  std::vector<int> pairings;  ///< by observation: index into the pairings offered, or -1
  double mahalanobis2 = 0.0;  ///< of the joint innovation
  int paired = 0;
  bool complete = true;  ///< false: the search hit max_nodes
};

/// Joint compatibility branch and bound (Neira and Tardos, 2001). Of all sets of pairings whose
/// joint innovation passes the chi-square gate, finds the one that minimises
///   D^2 + cue costs + unpaired_cost * (observations left out).
/// Unlike the largest set, this never takes a pairing that makes the joint innovation worse by more
/// than leaving it out costs. Immutable.
class JointCompatibility {
 public:
  explicit JointCompatibility(const JointCompatibilityLimits& limits);

  /// `S` holds 2x2 blocks of the innovation covariance, noise on the diagonal included, in the
  /// order of `pairings`; blocks of pairings that exclude each other are not read.
  JointHypothesis find(const std::vector<Pairing>& pairings, const Eigen::MatrixXd& S,
                       int observations) const;

  /// The best hypothesis, by the same measure, that contradicts `other`: that takes one at least of
  /// the observations which `other` pairs for another landmark. None that costs `within` more than
  /// `other` does; its pairings are then empty.
  JointHypothesis findRival(const std::vector<Pairing>& pairings, const Eigen::MatrixXd& S,
                            const std::vector<int>& other, double within) const;

  /// Largest squared Mahalanobis distance of `pairings` pairings.
  double gate(int pairings) const;

  const JointCompatibilityLimits& limits() const { return limits_; }

 private:
  JointCompatibilityLimits limits_;
  std::vector<double> gates_;  ///< of the usual numbers of pairings
};

}  // namespace hymm::core
