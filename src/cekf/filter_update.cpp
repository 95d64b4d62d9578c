/// What measurements do to the filter: their Jacobians times its covariance, and the joint update.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>

#include "cekf/blas.h"
#include "cekf/compressed_ekf.h"

namespace hymm::core {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

int strideOf(const MatrixXd& matrix) { return static_cast<int>(matrix.outerStride()); }

}  // namespace

MatrixXd CompressedEkf::measurementTimesCovariance(const SparseMeasurement& measurement) const {
  const int n = states(), nv = vehicle_states_;
  MatrixXd HP = MatrixXd::Zero(2, n);
  if (measurement.H_vehicle.cols() > 0) {
    HP.leftCols(nv) += measurement.H_vehicle.lazyProduct(vehicleCovariance());
    HP.rightCols(n - nv) +=
        measurement.H_vehicle.lazyProduct(P_.block(nv, 0, n - nv, nv).transpose());
  }
  for (int k = 0; k < SparseMeasurement::kPairs; ++k) {
    if (measurement.landmarks[k] == SparseMeasurement::kNone) continue;
    const int row = rowOf(measurement.landmarks[k]);
    const Matrix2d& H = measurement.H_landmarks[k];
    HP.leftCols(row) += H.lazyProduct(P_.block(row, 0, 2, row));
    Matrix2d own = P_.block<2, 2>(row, row);
    own(0, 1) = own(1, 0);
    HP.middleCols<2>(row) += H * own;
    const int below = n - row - 2;
    HP.rightCols(below) += H.lazyProduct(P_.block(row + 2, row, below, 2).transpose());
  }
  return HP;
}

MatrixXd CompressedEkf::measurementTimesPhi(const SparseMeasurement& measurement) const {
  MatrixXd Hphi = MatrixXd::Zero(2, origin_states_);
  if (measurement.H_vehicle.cols() > 0) {
    Hphi += measurement.H_vehicle.lazyProduct(phi_.topLeftCorner(vehicle_states_, origin_states_));
  }
  for (int k = 0; k < SparseMeasurement::kPairs; ++k) {
    if (measurement.landmarks[k] == SparseMeasurement::kNone) continue;
    const int row = rowOf(measurement.landmarks[k]);
    Hphi += measurement.H_landmarks[k] * phi_.block(row, 0, 2, origin_states_);
  }
  return Hphi;
}

Matrix2d CompressedEkf::innovationCovariance(const SparseMeasurement& a,
                                             const SparseMeasurement& b) const {
  flushMotion();
  const int nv = vehicle_states_;
  Matrix2d S = Matrix2d::Zero();
  const bool vehicle_a = a.H_vehicle.cols() > 0, vehicle_b = b.H_vehicle.cols() > 0;
  if (vehicle_a && vehicle_b) {
    const VehicleJacobian HP = a.H_vehicle.lazyProduct(vehicleCovariance());
    S += HP.lazyProduct(b.H_vehicle.transpose());
  }
  for (int i = 0; i < SparseMeasurement::kPairs; ++i) {
    if (a.landmarks[i] == SparseMeasurement::kNone) continue;
    const int row = rowOf(a.landmarks[i]);
    if (vehicle_b) {
      const VehicleJacobian HP = a.H_landmarks[i].lazyProduct(P_.block(row, 0, 2, nv));
      S += HP.lazyProduct(b.H_vehicle.transpose());
    }
  }
  for (int j = 0; j < SparseMeasurement::kPairs; ++j) {
    if (b.landmarks[j] == SparseMeasurement::kNone) continue;
    const int row = rowOf(b.landmarks[j]);
    if (vehicle_a) {
      S += a.H_vehicle.lazyProduct(P_.block(row, 0, 2, nv).transpose()) *
           b.H_landmarks[j].transpose();
    }
    for (int i = 0; i < SparseMeasurement::kPairs; ++i) {
      if (a.landmarks[i] == SparseMeasurement::kNone) continue;
      S += a.H_landmarks[i] * covariance(a.landmarks[i], b.landmarks[j]) *
           b.H_landmarks[j].transpose();
    }
  }
  return S;
}

MatrixXd CompressedEkf::measurementsTimesCovariance(
    const std::vector<SparseMeasurement>& measurements) const {
  MatrixXd HP(2 * static_cast<Eigen::Index>(measurements.size()), states());
  for (std::size_t k = 0; k < measurements.size(); ++k) {
    HP.middleRows<2>(2 * static_cast<Eigen::Index>(k)) =
        measurementTimesCovariance(measurements[k]);
  }
  return HP;
}

MatrixXd CompressedEkf::timesMeasurementsTransposed(
    const MatrixXd& HP, const std::vector<SparseMeasurement>& measurements) const {
  const auto m = static_cast<int>(HP.rows());
  MatrixXd S(m, m);
  for (int j = 0; j < m; j += 2) {
    // Rows from j on: the block column below and on the diagonal.
    const SparseMeasurement& column = measurements[static_cast<std::size_t>(j / 2)];
    auto block = S.block(j, j, m - j, 2);
    block.setZero();
    if (column.H_vehicle.cols() > 0) {
      block +=
          HP.bottomLeftCorner(m - j, vehicle_states_).lazyProduct(column.H_vehicle.transpose());
    }
    for (int k = 0; k < SparseMeasurement::kPairs; ++k) {
      if (column.landmarks[k] == SparseMeasurement::kNone) continue;
      block += HP.block(j, rowOf(column.landmarks[k]), m - j, 2)
                   .lazyProduct(column.H_landmarks[k].transpose());
    }
  }
  return S;
}

MatrixXd CompressedEkf::innovationCovariance(
    const std::vector<SparseMeasurement>& measurements) const {
  flushMotion();
  return timesMeasurementsTransposed(measurementsTimesCovariance(measurements), measurements);
}

std::optional<CompressedEkf::Linearised> CompressedEkf::linearise(
    const std::vector<SparseMeasurement>& measurements) const {
  flushMotion();
  const int m = 2 * static_cast<int>(measurements.size());
  Linearised result{measurementsTimesCovariance(measurements), MatrixXd(), VectorXd(m)};
  result.L = timesMeasurementsTransposed(result.HP, measurements);
  VectorXd innovations(m);
  for (int k = 0; k < m; k += 2) {
    const SparseMeasurement& row = measurements[static_cast<std::size_t>(k / 2)];
    innovations.segment<2>(k) = row.innovation;
    result.L.block<2, 2>(k, k) += row.noise;
  }
  const Eigen::LLT<Eigen::Ref<MatrixXd>, Eigen::Lower> llt(result.L);
  // The factorisation itself takes no notice of NaN, which then stands on the diagonal.
  const bool finite = innovations.allFinite() && result.L.diagonal().allFinite();
  if (!finite || llt.info() != Eigen::Success) return std::nullopt;
  result.whitened = llt.matrixL().solve(innovations);
  return result;
}

VectorXd CompressedEkf::statesAfter(const Linearised& linearised) const {
  const VectorXd weighted =
      linearised.L.triangularView<Eigen::Lower>().transpose().solve(linearised.whitened);
  return x_.head(states()) + linearised.HP.transpose() * weighted;
}

std::optional<VectorXd> CompressedEkf::statesAfter(
    const std::vector<SparseMeasurement>& measurements) const {
  const std::optional<Linearised> linearised = linearise(measurements);
  if (!linearised) return std::nullopt;
  return statesAfter(*linearised);
}

UpdateOutcome CompressedEkf::update(const std::vector<SparseMeasurement>& measurements) {
  if (measurements.empty()) return {};
  std::optional<Linearised> linearised = linearise(measurements);
  if (!linearised) return refusedUpdate();
  return update(measurements, std::move(*linearised));
}

UpdateOutcome CompressedEkf::update(const std::vector<SparseMeasurement>& measurements,
                                    Linearised linearised) {
  if (measurements.empty()) return {};
  const int m = 2 * static_cast<int>(measurements.size()), n = states(), n0 = origin_states_;
  MatrixXd Hphi(m, n0);
  for (int k = 0; k < m; k += 2) {
    Hphi.middleRows<2>(k) = measurementTimesPhi(measurements[static_cast<std::size_t>(k / 2)]);
  }

  // With S = L * L': every term needs its factors only as L^-1 * (.).
  MatrixXd& HP = linearised.HP;
  const VectorXd& y = linearised.whitened;
  blas::solveLower(m, n, linearised.L.data(), m, HP.data(), m);
  blas::solveLower(m, n0, linearised.L.data(), m, Hphi.data(), m);
  UpdateOutcome outcome;
  outcome.nis = y.squaredNorm();
  tellVehicle(measurements, linearised, outcome);
  if (landmarks_fixed_) {
    updateVehicle(linearised, Hphi);
    return outcome;
  }
  const VectorXd correction = HP.transpose() * y;
  x_.head(n) += correction;
  theta_.head(n0) += Hphi.transpose() * y;
  blas::syrkLower(true, n, m, -1.0, HP.data(), m, P_.data(), strideOf(P_));
  blas::syrkLower(true, n0, m, 1.0, Hphi.data(), m, psi_.data(), strideOf(psi_));
  blas::gemm(true, false, n, n0, m, -1.0, HP.data(), m, Hphi.data(), m, phi_.data(),
             strideOf(phi_));

  outcome.largest_landmark_move_m = largestMove(x_.head(n) - correction);
  return outcome;
}

void CompressedEkf::tellVehicle(const std::vector<SparseMeasurement>& measurements,
                                const Linearised& linearised, UpdateOutcome& outcome) const {
  MatrixXd H = MatrixXd::Zero(linearised.L.rows(), vehicle_states_);
  for (std::size_t k = 0; k < measurements.size(); ++k) {
    const VehicleJacobian& rows = measurements[k].H_vehicle;
    if (rows.cols() > 0) H.middleRows<2>(2 * static_cast<Eigen::Index>(k)) = rows;
  }
  linearised.L.triangularView<Eigen::Lower>().solveInPlace(H);
  outcome.vehicle_score = H.transpose() * linearised.whitened;
  outcome.vehicle_information = H.transpose() * H;
}

/// With the landmarks' rows of the gain zero: P_vv and P_vl change as ever, P_ll does not, nor does
/// anything that is passive but for its covariance with the vehicle, which is the vehicle's rows of
/// phi. `whitened`, `Hphi`: as update() has them, times L^-1.
void CompressedEkf::updateVehicle(const Linearised& whitened, const MatrixXd& Hphi) {
  const auto m = static_cast<int>(Hphi.rows());
  const int n = states(), nv = vehicle_states_;
  const MatrixXd& HP = whitened.HP;
  x_.head(nv) += HP.leftCols(nv).transpose() * whitened.whitened;
  blas::gemm(true, false, n, nv, m, -1.0, HP.data(), m, HP.data(), m, P_.data(), strideOf(P_));
  blas::gemm(true, false, nv, origin_states_, m, -1.0, HP.data(), m, Hphi.data(), m, phi_.data(),
             strideOf(phi_));
}

double CompressedEkf::largestMove(const VectorXd& states) const {
  double largest2 = 0.0;
  for (std::size_t k = 0; k < active_slots_.size(); ++k) {
    if (!is_place_[static_cast<std::size_t>(active_slots_[k])]) continue;
    const auto row = vehicle_states_ + 2 * static_cast<Eigen::Index>(k);
    const double move2 = (x_.segment<2>(row) - states.segment<2>(row)).squaredNorm();
    largest2 = std::max(largest2, move2);
  }
  return std::sqrt(largest2);
}

}  // namespace hymm::core
