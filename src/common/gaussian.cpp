#include "common/gaussian.h"

#include <Eigen/Eigenvalues>

namespace hymm::core {
namespace {

// Rounding of a message that went through float or text.
constexpr double kRelativeAsymmetry = 1e-6;
constexpr double kRelativeNegativity = 1e-9;

bool isSymmetric(const Eigen::MatrixXd& matrix) {
  const double scale = matrix.cwiseAbs().maxCoeff();
  return (matrix - matrix.transpose()).cwiseAbs().maxCoeff() <= kRelativeAsymmetry * scale;
}

}  // namespace

bool isCovariance(const Eigen::Matrix2d& matrix) {
  return matrix.allFinite() && isSymmetric(matrix) && matrix(0, 0) > 0.0 &&
         matrix.determinant() > 0.0;
}

bool isSemiDefiniteCovariance(const Eigen::MatrixXd& matrix) {
  if (matrix.rows() != matrix.cols() || matrix.size() == 0 || !matrix.allFinite()) return false;
  if (!isSymmetric(matrix)) return false;
  const Eigen::VectorXd eigenvalues =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
  return eigenvalues.minCoeff() >= -kRelativeNegativity * eigenvalues.cwiseAbs().maxCoeff();
}

}  // namespace hymm::core
