#pragma once

#include <vector>

#include <Eigen/Core>

#include "cekf/joint_compatibility.h"

namespace hymm::core {

/// How much pairings prove. Natural logarithm of the likelihood of their innovations, jointly, over
/// that of finding other objects there by chance:
///   -1/2 (D^2 + cue costs + ln|2 pi S|) - sum of ln(chance density).
/// Where a landmark's place is well known, one match is plenty; where it is so uncertain that any
/// object might be there, one proves nothing, and several have to agree. `chosen`: indices into
/// `pairings`; `S` as for JointCompatibility::find(). Minus infinity if S is not positive definite.
double logOdds(const std::vector<int>& chosen, const std::vector<Pairing>& pairings,
               const Eigen::MatrixXd& S);
/// The same of one pairing, of innovation covariance `S`.
double logOdds(const Pairing& pairing, const Eigen::Matrix2d& S);

/// Of a hypothesis (by observation: index into `pairings`, or -1) what no other one disputes. Trees
/// in a row look the same from one tree on, and the best hypothesis is then as good as the next.
/// One that takes observations for other landmarks, and is less than `least_log_odds` less likely,
/// is a rival; what it does not share is left out. Ascending.
std::vector<int> undisputedPairings(const JointCompatibility& joint, std::vector<int> hypothesis,
                                    const std::vector<Pairing>& pairings, const Eigen::MatrixXd& S,
                                    double least_log_odds);

/// Of the pairings chosen, those that are no coincidence: each that by itself, or given such ones,
/// has at least `least_log_odds`; and all others if these together, given such ones, have it.
/// Ascending.
std::vector<int> provenPairings(const std::vector<int>& chosen,
                                const std::vector<Pairing>& pairings, const Eigen::MatrixXd& S,
                                double least_log_odds);

}  // namespace hymm::core
