#pragma once

#include <vector>

#include <Eigen/Core>

#include "cekf/pairing.h"

namespace hymm::core {

/// Cholesky factor of the joint innovation covariance of a hypothesis that grows and shrinks by one
/// pairing at a time, S_H = L * L', with L^-1 * innovations. A row costs the square of the pairings
/// before it, and nothing where it already stands there.
class JointFactor {
 public:
  /// `S`: innovation covariance of all `pairings`, 2x2 blocks in their order, whole; both have to
  /// outlive this. A hypothesis has at most `most` pairings.
  JointFactor(const std::vector<Pairing>& pairings, const Eigen::MatrixXd& S, std::size_t most);

  /// What a pairing adds to those before it.
  struct Addition {
    double distance2;       ///< to the squared Mahalanobis distance; infinite if S_H is not
                            ///< positive definite
    double log_deviations;  ///< to ln|S_H| / 2
  };

  /// Makes `pairing` the one at `place`, after those that were put at [0, place) last. What was
  /// behind is forgotten.
  Addition put(std::size_t place, int pairing);

 private:
  Addition compute(std::size_t place, int pairing);

  const std::vector<Pairing>& pairings_;
  const Eigen::MatrixXd& S_;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> L_;  ///< lower triangle
  Eigen::VectorXd y_;  ///< L^-1 * innovations

  struct Entry {
    int pairing;
    Addition addition;
  };
  std::vector<Entry> entries_;  ///< those at the places that are known
};

}  // namespace hymm::core
