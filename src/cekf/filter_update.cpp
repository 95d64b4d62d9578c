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
using TwoColumns = Eigen::Matrix<double, Eigen::Dynamic, 2>;

namespace {

int strideOf(const MatrixXd& matrix) { return static_cast<int>(matrix.outerStride()); }

}  // namespace

Matrix2d CompressedEkf::covarianceOfRows(int row_a, int row_b) const {
  if (row_a > row_b) return P_.block<2, 2>(row_a, row_b);
  if (row_a < row_b) return P_.block<2, 2>(row_b, row_a).transpose();
  Matrix2d own = P_.block<2, 2>(row_a, row_a);
  own(0, 1) = own(1, 0);
  return own;
}

MatrixXd CompressedEkf::vehicleJacobian(const std::vector<SparseMeasurement>& measurements) const {
  MatrixXd H = MatrixXd::Zero(2 * static_cast<Eigen::Index>(measurements.size()), vehicle_states_);
  for (std::size_t k = 0; k < measurements.size(); ++k) {
    const VehicleJacobian& rows = measurements[k].H_vehicle;
    if (rows.cols() > 0) H.middleRows<2>(2 * static_cast<Eigen::Index>(k)) = rows;
  }
  return H;
}

MatrixXd CompressedEkf::measurementsTimesCovariance(
    const std::vector<SparseMeasurement>& measurements) const {
  const int n = states(), nv = vehicle_states_;
  const MatrixXd H_vehicle = vehicleJacobian(measurements);
  const auto m = static_cast<int>(H_vehicle.rows());
  MatrixXd HP = MatrixXd::Zero(m, n);
  HP.leftCols(nv) = H_vehicle.lazyProduct(vehicleCovariance());
  blas::gemm(false, true, m, n - nv, nv, 1.0, H_vehicle.data(), m, P_.data() + nv, strideOf(P_),
             HP.data() + std::ptrdiff_t{nv} * m, m);
  for (int i = 0; i < m; i += 2) {
    const SparseMeasurement& measurement = measurements[static_cast<std::size_t>(i / 2)];
    auto rows = HP.middleRows<2>(i);
    for (int k = 0; k < SparseMeasurement::kPairs; ++k) {
      if (measurement.landmarks[k] == SparseMeasurement::kNone) continue;
      const int row = rowOf(measurement.landmarks[k]), below = n - row - 2;
      const Matrix2d& H = measurement.H_landmarks[k];
      rows.leftCols(row) += H.lazyProduct(P_.block(row, 0, 2, row));
      rows.middleCols<2>(row) += H * covarianceOfRows(row, row);
      rows.rightCols(below) += H.lazyProduct(P_.block(row + 2, row, below, 2).transpose());
    }
  }
  return HP;
}

MatrixXd CompressedEkf::measurementsTimesPhi(
    const std::vector<SparseMeasurement>& measurements) const {
  const int n0 = origin_states_;
  const MatrixXd H_vehicle = vehicleJacobian(measurements);
  const auto m = static_cast<int>(H_vehicle.rows());
  MatrixXd Hphi = MatrixXd::Zero(m, n0);
  blas::gemm(false, false, m, n0, vehicle_states_, 1.0, H_vehicle.data(), m, phi_.data(),
             strideOf(phi_), Hphi.data(), m);
  for (int i = 0; i < m; i += 2) {
    const SparseMeasurement& measurement = measurements[static_cast<std::size_t>(i / 2)];
    for (int k = 0; k < SparseMeasurement::kPairs; ++k) {
      if (measurement.landmarks[k] == SparseMeasurement::kNone) continue;
      Hphi.middleRows<2>(i) += measurement.H_landmarks[k].lazyProduct(
          phi_.block(rowOf(measurement.landmarks[k]), 0, 2, n0));
    }
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

/// H * P is worked out where H' needs it alone: at the vehicle's states, and at those landmarks
/// that are measured.
MatrixXd CompressedEkf::innovationCovariance(
    const std::vector<SparseMeasurement>& measurements) const {
  flushMotion();
  const int nv = vehicle_states_;
  const MatrixXd H_vehicle = vehicleJacobian(measurements);
  const auto m = static_cast<int>(H_vehicle.rows());
  const auto visit = [&](int i, auto&& add) {
    const SparseMeasurement& measurement = measurements[static_cast<std::size_t>(i / 2)];
    for (int k = 0; k < SparseMeasurement::kPairs; ++k) {
      if (measurement.landmarks[k] == SparseMeasurement::kNone) continue;
      add(rowOf(measurement.landmarks[k]), measurement.H_landmarks[k]);
    }
  };
  MatrixXd HP_vehicle = H_vehicle.lazyProduct(vehicleCovariance());
  for (int i = 0; i < m; i += 2) {
    visit(i, [&](int row, const Matrix2d& H) {
      HP_vehicle.middleRows<2>(i) += H.lazyProduct(P_.block(row, 0, 2, nv));
    });
  }
  MatrixXd S(m, m);
  for (int j = 0; j < m; j += 2) {
    auto column = S.block(j, j, m - j, 2);
    column = HP_vehicle.bottomRows(m - j).lazyProduct(H_vehicle.middleRows<2>(j).transpose());
    visit(j, [&](int row, const Matrix2d& H) {
      TwoColumns HP = H_vehicle.bottomRows(m - j).lazyProduct(P_.block(row, 0, 2, nv).transpose());
      for (int i = j; i < m; i += 2) {
        visit(i, [&](int other_row, const Matrix2d& other_H) {
          HP.middleRows<2>(i - j) += other_H * covarianceOfRows(other_row, row);
        });
      }
      column += HP.lazyProduct(H.transpose());
    });
  }
  return S;
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

std::vector<Eigen::Vector2d> CompressedEkf::movesBy(
    const std::vector<SparseMeasurement>& measurements, const std::vector<int>& slots) const {
  std::vector<Eigen::Vector2d> moves;
  const std::optional<Linearised> linearised = linearise(measurements);
  if (!linearised) return moves;
  const VectorXd weighted =
      linearised->L.triangularView<Eigen::Lower>().transpose().solve(linearised->whitened);
  const VectorXd active = linearised->HP.transpose() * weighted;
  const VectorXd origins = measurementsTimesPhi(measurements).transpose() * weighted;
  for (const int slot : slots) {
    const int row = rowOf(slot);
    if (row >= 0) {
      moves.emplace_back(active.segment<2>(row));
    } else {
      moves.emplace_back(originCovariance(slot).transpose() * origins);
    }
  }
  return moves;
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
  MatrixXd Hphi = measurementsTimesPhi(measurements);

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
  MatrixXd H = vehicleJacobian(measurements);
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
