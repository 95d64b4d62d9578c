#pragma once

#include <vector>

#include <Eigen/Core>

namespace hymm::core {

/// What the filter did between two global updates to everything. States are addressed by their
/// index in the store. With W_b = cov(b, origins) at the interval's start, for active a and passive
/// b, c:
///   P_ab = phi_a * W_b',  P_bc = P_bc0 - W_b * psi * W_c',  x_b = x_b0 + W_b * theta.
struct IntervalEffect {
  std::vector<int> origins;  ///< what the columns of phi, psi and theta stand for
  std::vector<int> active;   ///< what the rows of phi, x and P stand for
  Eigen::MatrixXd phi;       ///< active x origins
  Eigen::MatrixXd psi;       ///< origins x origins, symmetric, positive semi-definite
  Eigen::VectorXd theta;
  Eigen::VectorXd x;  ///< of the active states, at the interval's end
  Eigen::MatrixXd P;  ///< of the active states, symmetric
  int size = 0;       ///< indices of all states are below

  template <class Archive>
  void describeState(Archive& archive) {
    archive(origins, active, phi, psi, theta, x, P, size);
  }
};

/// A matrix F with F * F' = psi.
Eigen::MatrixXd factorOf(const Eigen::MatrixXd& psi);

}  // namespace hymm::core
