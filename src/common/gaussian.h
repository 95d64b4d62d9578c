#pragma once

#include <Eigen/Core>

namespace hymm::core {

/// Whether every entry is finite and the matrix is symmetric positive definite, to rounding.
bool isCovariance(const Eigen::Matrix2d& matrix);

/// Whether every entry is finite and the matrix is symmetric positive semi-definite, to rounding.
bool isSemiDefiniteCovariance(const Eigen::MatrixXd& matrix);

}  // namespace hymm::core
