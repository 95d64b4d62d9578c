#include "cekf/interval_effect.h"

#include <Eigen/Cholesky>

namespace hymm::core {

Eigen::MatrixXd factorOf(const Eigen::MatrixXd& psi) {
  // Pivoted, since psi has the rank of the measurements of the interval at most.
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(psi);
  const Eigen::VectorXd root = ldlt.vectorD().cwiseMax(0.0).cwiseSqrt();
  const Eigen::MatrixXd L = ldlt.matrixL();
  return ldlt.transpositionsP().transpose() * (L * root.asDiagonal()).eval();
}

}  // namespace hymm::core
