#include "relocaliser/block_bound.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace hymm::core {
namespace {

using Eigen::MatrixXd;

// States that are known exactly (the frame's own) get this share of the mean variance, so that the
// bound can be inverted. It is added, never taken away.
constexpr double kFloorShare = 1e-12;

// Rounding of the eigenvalue that the common factor rests on.
constexpr double kRounding = 1e-9;

int sizeOf(const std::vector<CovarianceBlock>& blocks) {
  int size = 0;
  for (const CovarianceBlock& block : blocks) {
    if (block.size < 1 || !(block.weight > 0.0)) {
      throw std::invalid_argument("A covariance block needs a positive size and weight.");
    }
    size += block.size;
  }
  return size;
}

/// (37): each block plus k |C| of each of its cross terms.
MatrixXd computePairwiseBound(const MatrixXd& P, const std::vector<CovarianceBlock>& blocks) {
  MatrixXd bound = MatrixXd::Zero(P.rows(), P.cols());
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < blocks.size(); row += blocks[i++].size) {
    const Eigen::Index m = blocks[i].size;
    bound.block(row, row, m, m) += P.block(row, row, m, m);
    Eigen::Index column = row + m;
    for (std::size_t j = i + 1; j < blocks.size(); column += blocks[j++].size) {
      const Eigen::Index n = blocks[j].size;
      const MatrixXd C = P.block(row, column, m, n);
      if (C.isZero(0.0)) continue;
      const Eigen::JacobiSVD<MatrixXd> svd(C, Eigen::ComputeThinU | Eigen::ComputeThinV);
      const MatrixXd& U = svd.matrixU();
      const MatrixXd& V = svd.matrixV();
      const double k = blocks[i].weight / blocks[j].weight;
      bound.block(row, row, m, m) += k * U * svd.singularValues().asDiagonal() * U.transpose();
      bound.block(column, column, n, n) +=
          1.0 / k * V * svd.singularValues().asDiagonal() * V.transpose();
    }
  }
  return bound;
}

/// The least s with s * bound >= P.
double computeLeastFactor(const MatrixXd& bound, const MatrixXd& P) {
  const Eigen::LLT<MatrixXd> factor(bound);
  const MatrixXd left = factor.matrixL().solve(P);
  const MatrixXd whitened = factor.matrixL().solve(left.transpose());
  const MatrixXd symmetric = 0.5 * (whitened + whitened.transpose());
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(symmetric, Eigen::EigenvaluesOnly)
      .eigenvalues()
      .maxCoeff();
}

}  // namespace

MatrixXd computeBlockBound(const MatrixXd& covariance, const std::vector<CovarianceBlock>& blocks) {
  if (covariance.rows() != covariance.cols() || sizeOf(blocks) != covariance.rows()) {
    throw std::invalid_argument("The blocks do not fill the covariance that is to be bounded.");
  }
  if (blocks.empty()) return covariance;
  const double mean_variance = covariance.trace() / static_cast<double>(covariance.rows());
  if (!(mean_variance > 0.0)) return covariance;
  MatrixXd bound = computePairwiseBound(covariance, blocks);
  bound.diagonal().array() += kFloorShare * mean_variance;
  return bound * std::min(1.0, computeLeastFactor(bound, covariance) + kRounding);
}

double nuclearNorm(const Eigen::Matrix2d& C) {
  // (s1 + s2)^2 = s1^2 + s2^2 + 2 s1 s2.
  return std::sqrt(C.squaredNorm() + 2.0 * std::abs(C.determinant()));
}

}  // namespace hymm::core
