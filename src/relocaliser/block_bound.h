#pragma once

#include <vector>

#include <Eigen/Core>

namespace hymm::core {

/// One block of a covariance that is to be de-correlated.
struct CovarianceBlock {
  int size = 2;  ///< states
  /// Weight c of the block: k_ij = c_i / c_j of (37). A block of greater weight takes more of the
  /// inflation that its cross terms cost, and leaves less to the others.
  double weight = 1.0;
};

/// Bound of a covariance by one without cross terms between `blocks`, which follow each other on
/// its diagonal: the paper's (37) for blocks, by
///   [0 C; C' 0] <= diag(k (C C')^1/2, 1/k (C' C)^1/2)
/// and then made as small as a common factor can make it. The result minus `covariance` is positive
/// semi-definite. With all weights 1 the trace is the least that (37) can give.
/// Throws std::invalid_argument unless the covariance is square and the blocks fill it.
Eigen::MatrixXd computeBlockBound(const Eigen::MatrixXd& covariance,
                                  const std::vector<CovarianceBlock>& blocks);

/// Sum of the singular values of a 2x2 matrix: half of what its cross term adds to the trace of
/// the bound with k = 1.
double nuclearNorm(const Eigen::Matrix2d& C);

}  // namespace hymm::core
