/// How landmarks enter and leave the active part of the filter.
#include <algorithm>
#include <stdexcept>
#include <string>

#include "cekf/compressed_ekf.h"

namespace hymm::core {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;
using TwoColumns = Eigen::Matrix<double, Eigen::Dynamic, 2>;

void CompressedEkf::activate(int slot) {
  if (isActive(slot)) return;
  flushMotion();
  const int row = states(), n0 = origin_states_;
  const TwoColumns W = originCovariance(slot);
  const TwoColumns psi_W = psiTimes(W);
  const int index = storeIndex(slot);
  const Matrix2d own = store_->covariance({index, index + 1}, index);
  const Vector2d position = store_->state(index) + W.transpose() * theta_.head(n0);

  reserveActive(row + 2, n0 + 2);
  x_.segment<2>(row) = position;
  P_.block(row, 0, 2, row) = (phi_.topLeftCorner(row, n0) * W).transpose();
  P_.block<2, 2>(row, row) = own - W.transpose() * psi_W;
  phi_.block(0, n0, row, 2).setZero();
  phi_.block(row, 0, 2, n0) = -psi_W.transpose();
  phi_.block<2, 2>(row, n0).setIdentity();
  psi_.block(n0, 0, 2, n0 + 2).setZero();
  theta_.segment<2>(n0).setZero();

  origin_indices_.insert(origin_indices_.end(), {index, index + 1});
  origin_states_ += 2;
  active_slots_.push_back(slot);
  rows_[static_cast<std::size_t>(slot)] = row;
}

int CompressedEkf::append(const Vector2d& position, const VehicleJacobian& G, const Matrix2d& noise,
                          const SlotJacobian& other, const SlotJacobian& another) {
  flushMotion();
  // As a measurement of zero noise depends on the states, so does the new landmark.
  SparseMeasurement dependence;
  dependence.H_vehicle = G;
  dependence.landmarks[0] = other.slot;
  dependence.H_landmarks[0] = other.G;
  dependence.landmarks[1] = another.slot;
  dependence.H_landmarks[1] = another.G;
  const Matrix2d covariance = innovationCovariance(dependence, dependence) + noise;
  const MatrixXd cross = measurementsTimesCovariance({dependence});
  const MatrixXd phi = measurementsTimesPhi({dependence});
  const int slot = appendRow(position, covariance, true);
  const int row = rowOf(slot);
  P_.block(row, 0, 2, row) = cross;
  phi_.block(row, 0, 2, origin_states_) = phi;
  ++landmark_count_;
  return slot;
}

int CompressedEkf::appendQuantities(const Vector2d& mean, const Matrix2d& covariance) {
  flushMotion();
  const int slot = appendRow(mean, covariance, false);
  const int row = rowOf(slot);
  P_.block(row, 0, 2, row).setZero();
  phi_.block(row, 0, 2, origin_states_).setZero();
  return slot;
}

/// A new slot's row, but for what it has in common with others.
int CompressedEkf::appendRow(const Vector2d& mean, const Matrix2d& covariance, bool is_place) {
  const int row = states(), slot = takeSlot(is_place);
  reserveActive(row + 2, origin_states_);
  x_.segment<2>(row) = mean;
  P_.block<2, 2>(row, row) = covariance;
  active_slots_.push_back(slot);
  rows_[static_cast<std::size_t>(slot)] = row;
  return slot;
}

void CompressedEkf::remove(int slot) {
  if (slot < 0 || slot >= static_cast<int>(rows_.size()) || rowOf(slot) == kFree) {
    throw std::invalid_argument("There is no landmark in slot " + std::to_string(slot));
  }
  const int row = rowOf(slot);
  if (row >= 0) {
    flushMotion();
    moveLastLandmarkTo(row);
  }
  const bool is_origin = std::find(origin_indices_.begin(), origin_indices_.end(),
                                   storeIndex(slot)) != origin_indices_.end();
  (is_origin ? retired_slots_ : free_slots_).push_back(slot);
  rows_[static_cast<std::size_t>(slot)] = kFree;
  if (is_place_[static_cast<std::size_t>(slot)]) --landmark_count_;
}

void CompressedEkf::moveLastLandmarkTo(int row) {
  const int last = states() - 2;
  if (row != last) {
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < last; ++j) {
        if (j != row && j != row + 1) {
          setCovarianceEntry(row + i, j, covarianceEntry(last + i, j));
        }
      }
    }
    P_.block<2, 2>(row, row) = P_.block<2, 2>(last, last);
    phi_.block(row, 0, 2, origin_states_) = phi_.block(last, 0, 2, origin_states_).eval();
    x_.segment<2>(row) = x_.segment<2>(last).eval();
    const int moved = active_slots_.back();
    active_slots_[static_cast<std::size_t>((row - vehicle_states_) / 2)] = moved;
    rows_[static_cast<std::size_t>(moved)] = row;
  }
  active_slots_.pop_back();
}

void CompressedEkf::addVehicleError(int slot, const Vector2d& gain, int vehicle_state) {
  flushMotion();
  const int row = rowOf(slot), n = states();
  VectorXd with_all(n);
  for (int k = 0; k < n; ++k) with_all[k] = covarianceEntry(k, vehicle_state);
  const Vector2d with_own = with_all.segment<2>(row);
  for (int i = 0; i < 2; ++i) {
    for (int k = 0; k < n; ++k) {
      if (k == row || k == row + 1) continue;
      setCovarianceEntry(row + i, k, covarianceEntry(row + i, k) + gain[i] * with_all[k]);
    }
  }
  P_.block<2, 2>(row, row) += gain * with_own.transpose() + with_own * gain.transpose() +
                              gain * with_all[vehicle_state] * gain.transpose();
  phi_.block(row, 0, 2, origin_states_) += gain * phi_.block(vehicle_state, 0, 1, origin_states_);
}

void CompressedEkf::redefineErrors(const std::function<MatrixXd(const MatrixXd&)>& T) {
  const MatrixXd TP = T(activeCovariance());
  const int n = states();
  P_.topLeftCorner(n, n) = T(TP.transpose());
  phi_.topLeftCorner(n, origin_states_) = T(phi_.topLeftCorner(n, origin_states_));
}

void CompressedEkf::addRigidNoise(const std::vector<int>& slots, const Eigen::Matrix3d& noise) {
  flushMotion();
  const int n = states();
  Eigen::Matrix<double, Eigen::Dynamic, 3> A = Eigen::Matrix<double, Eigen::Dynamic, 3>::Zero(n, 3);
  A.topRows<3>().setIdentity();
  for (const int slot : slots) {
    const int row = rowOf(slot);
    A.middleRows<2>(row) = rigidMotion(x_.segment<2>(row) - x_.head<2>());
  }
  P_.topLeftCorner(n, n).triangularView<Eigen::Lower>() += A * noise * A.transpose();
}

void CompressedEkf::fade(int slot, double kept, const Matrix2d& stationary) {
  flushMotion();
  const int row = rowOf(slot), below = states() - row - 2;
  x_.segment<2>(row) *= kept;
  P_.block(row, 0, 2, row) *= kept;
  P_.block<2, 2>(row, row) *= kept * kept;
  P_.block<2, 2>(row, row) += (1.0 - kept * kept) * stationary;
  P_.block(row + 2, row, below, 2) *= kept;
  phi_.block(row, 0, 2, origin_states_) *= kept;
}

void CompressedEkf::initialiseVehicleStates(int first, const VectorXd& value, const MatrixXd& G,
                                            const MatrixXd& noise) {
  flushMotion();
  const int nv = vehicle_states_, count = static_cast<int>(value.size()), n = states();
  const MatrixXd P_vv = vehicleCovariance();
  MatrixXd new_vv = P_vv;
  new_vv.middleRows(first, count) = G * P_vv;
  new_vv.middleCols(first, count) = new_vv.middleRows(first, count).transpose().eval();
  new_vv.block(first, first, count, count) = G * P_vv * G.transpose() + noise;
  const MatrixXd P_lv = P_.block(nv, 0, n - nv, nv);
  P_.topLeftCorner(nv, nv) = new_vv;
  P_.block(nv, first, n - nv, count) = P_lv * G.transpose();
  phi_.block(first, 0, count, origin_states_) = (G * phi_.topLeftCorner(nv, origin_states_)).eval();
  x_.segment(first, count) = value;
}

void CompressedEkf::reserveActive(int states, int origin_states) {
  const auto grown = [](Eigen::Index capacity, int needed) {
    return needed <= capacity ? capacity
                              : std::max<Eigen::Index>(needed, capacity + capacity / 2 + 32);
  };
  const Eigen::Index rows = grown(x_.size(), states);
  const Eigen::Index columns = grown(theta_.size(), origin_states);
  if (rows > P_.rows()) P_.conservativeResize(rows, rows);
  if (rows > x_.size()) x_.conservativeResize(rows);
  if (rows > phi_.rows() || columns > phi_.cols()) phi_.conservativeResize(rows, columns);
  if (columns > psi_.rows()) psi_.conservativeResize(columns, columns);
  if (columns > theta_.size()) theta_.conservativeResize(columns);
}

int CompressedEkf::takeSlot(bool is_place) {
  if (free_slots_.empty()) {
    free_slots_.push_back(static_cast<int>(rows_.size()));
    rows_.push_back(kFree);
    is_place_.push_back(is_place);
  }
  const int slot = free_slots_.back();
  free_slots_.pop_back();
  is_place_[static_cast<std::size_t>(slot)] = is_place;
  return slot;
}

}  // namespace hymm::core
