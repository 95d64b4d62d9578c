#include "benchmark/dense_ekf.h"

#include <Eigen/Cholesky>
#include <cblas.h>

namespace hymm::benchmarks {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

DenseEkf::DenseEkf(const VectorXd& vehicle, const MatrixXd& covariance, int landmarks)
    : nv_(static_cast<int>(vehicle.size())),
      n_(nv_),
      x_(nv_ + 2 * landmarks),
      P_(nv_ + 2 * landmarks, nv_ + 2 * landmarks),
      pending_J_(MatrixXd::Identity(nv_, nv_)) {
  openblas_set_num_threads(1);
  x_.head(nv_) = vehicle;
  P_.topLeftCorner(nv_, nv_) = covariance;
}

void DenseEkf::predict(const VectorXd& vehicle, const MatrixXd& J, const MatrixXd& Q) {
  x_.head(nv_) = vehicle;
  P_.topLeftCorner(nv_, nv_) = (J * P_.topLeftCorner(nv_, nv_) * J.transpose() + Q).eval();
  pending_J_ = (J * pending_J_).eval();
}

void DenseEkf::flushMotion() {
  P_.block(nv_, 0, n_ - nv_, nv_) *= pending_J_.transpose();
  pending_J_.setIdentity();
}

MatrixXd DenseEkf::covarianceTimesMeasurements(const std::vector<Measurement>& measurements) const {
  MatrixXd PH(n_, 2 * static_cast<Eigen::Index>(measurements.size()));
  for (std::size_t k = 0; k < measurements.size(); ++k) {
    const Measurement& z = measurements[k];
    auto columns = PH.middleCols<2>(2 * static_cast<Eigen::Index>(k));
    columns.noalias() = P_.topLeftCorner(n_, nv_) * z.H_vehicle.transpose();
    columns.topRows(nv_) = P_.topLeftCorner(nv_, nv_) * z.H_vehicle.transpose();
    const int row = rowOf(z.landmark), below = n_ - row - 2;
    Matrix2d own = P_.block<2, 2>(row, row);
    own(0, 1) = own(1, 0);
    const Matrix2d Ht = z.H_landmark.transpose();
    columns.topRows(row) += P_.block(row, 0, 2, row).transpose() * Ht;
    columns.middleRows<2>(row) += own * Ht;
    columns.bottomRows(below) += P_.block(row + 2, row, below, 2) * Ht;
  }
  return PH;
}

bool DenseEkf::update(const std::vector<Measurement>& measurements) {
  if (measurements.empty()) return true;
  flushMotion();
  MatrixXd W = covarianceTimesMeasurements(measurements);
  const auto m = static_cast<int>(W.cols());
  MatrixXd S(m, m);
  VectorXd z(m);
  for (int k = 0; k < m; k += 2) {
    const Measurement& row = measurements[static_cast<std::size_t>(k / 2)];
    S.middleRows<2>(k) =
        row.H_vehicle * W.topRows(nv_) + row.H_landmark * W.middleRows<2>(rowOf(row.landmark));
    S.block<2, 2>(k, k) += row.noise;
    z.segment<2>(k) = row.innovation;
  }
  const Eigen::LLT<MatrixXd> llt(S);
  if (llt.info() != Eigen::Success) return false;
  const MatrixXd L = llt.matrixL();
  cblas_dtrsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit, n_, m, 1.0, L.data(),
              m, W.data(), n_);
  x_.head(n_) += W * llt.matrixL().solve(z);
  const auto stride = static_cast<int>(P_.outerStride());
  cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, n_, m, -1.0, W.data(), n_, 1.0, P_.data(),
              stride);
  P_.topLeftCorner(nv_, nv_) = MatrixXd(P_.topLeftCorner(nv_, nv_).selfadjointView<Eigen::Lower>());
  return true;
}

int DenseEkf::append(const Vector2d& position, const Eigen::Matrix<double, 2, Eigen::Dynamic>& G,
                     const Matrix2d& noise) {
  flushMotion();
  const int row = n_;
  const MatrixXd GP = G * P_.topLeftCorner(nv_, nv_);
  P_.block(row, 0, 2, nv_) = GP;
  P_.block(row, nv_, 2, row - nv_) = G * P_.block(nv_, 0, row - nv_, nv_).transpose();
  P_.block<2, 2>(row, row) = GP * G.transpose() + noise;
  x_.segment<2>(row) = position;
  n_ += 2;
  return landmarkCount() - 1;
}

}  // namespace hymm::benchmarks
