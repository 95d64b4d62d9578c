#include "cekf/compressed_ekf.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <unordered_set>

#include <Eigen/Cholesky>

#include "cekf/blas.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;
using TwoColumns = Eigen::Matrix<double, Eigen::Dynamic, 2>;

int strideOf(const MatrixXd& matrix) { return static_cast<int>(matrix.outerStride()); }

/// What has to be read of an interval before, to read `indices` after `effect`: its origins, and
/// those that it left passive.
std::vector<int> neededBefore(const IntervalEffect& effect, const std::vector<int>& indices) {
  std::vector<int> needed = effect.origins;
  const std::unordered_set<int> active(effect.active.begin(), effect.active.end());
  std::copy_if(indices.begin(), indices.end(), std::back_inserter(needed),
               [&](int index) { return active.count(index) == 0; });
  return needed;
}

/// The symmetric matrix whose lower triangle is the leading n x n block of `storage`.
auto symmetric(const MatrixXd& storage, int n) {
  return storage.topLeftCorner(n, n).selfadjointView<Eigen::Lower>();
}

}  // namespace

CompressedEkf::CompressedEkf(const VectorXd& vehicle, const MatrixXd& covariance,
                             SerialWorker::Mode global_updates)
    : vehicle_states_(static_cast<int>(vehicle.size())),
      store_(std::make_unique<PassiveStore>(global_updates)) {
  if (vehicle_states_ < 1 || vehicle_states_ > kMaxVehicleStates ||
      covariance.rows() != vehicle.size() || covariance.cols() != vehicle.size()) {
    throw std::invalid_argument("CompressedEkf takes 1 to " + std::to_string(kMaxVehicleStates) +
                                " vehicle states and a covariance of the same size");
  }
  x_ = vehicle;
  P_ = covariance;
  startInterval();
}

void CompressedEkf::startInterval() {
  active_slots_.clear();
  origin_indices_.resize(static_cast<std::size_t>(vehicle_states_));
  std::iota(origin_indices_.begin(), origin_indices_.end(), 0);
  origin_states_ = vehicle_states_;
  reserveActive(vehicle_states_, vehicle_states_);
  phi_.topLeftCorner(vehicle_states_, vehicle_states_).setIdentity();
  psi_.topLeftCorner(vehicle_states_, vehicle_states_).setZero();
  theta_.head(vehicle_states_).setZero();
  pending_J_ = MatrixXd::Identity(vehicle_states_, vehicle_states_);
  motion_pending_ = false;
}

MatrixXd CompressedEkf::vehicleCovariance() const { return symmetric(P_, vehicle_states_); }

Vector2d CompressedEkf::landmark(int slot) const {
  const int row = rowOf(slot);
  if (row >= 0) return x_.segment<2>(row);
  return store_->state(storeIndex(slot)) +
         originCovariance(slot).transpose() * theta_.head(origin_states_);
}

Matrix2d CompressedEkf::covariance(int slot_a, int slot_b) const {
  flushMotion();
  const int row_a = rowOf(slot_a), row_b = rowOf(slot_b);
  Matrix2d block;
  if (row_a >= 0 && row_b >= 0) {
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) block(i, j) = covarianceEntry(row_a + i, row_b + j);
    }
    return block;
  }
  if (row_a >= 0) return phi_.block(row_a, 0, 2, origin_states_) * originCovariance(slot_b);
  if (row_b >= 0) return covariance(slot_b, slot_a).transpose();
  const int index_a = storeIndex(slot_a);
  block = store_->covariance({index_a, index_a + 1}, storeIndex(slot_b));
  return block - originCovariance(slot_a).transpose() * psiTimes(originCovariance(slot_b));
}

TwoColumns CompressedEkf::vehicleLandmarkCovariance(int slot) const {
  flushMotion();
  const int row = rowOf(slot);
  if (row >= 0) return P_.block(row, 0, 2, vehicle_states_).transpose();
  return phi_.topLeftCorner(vehicle_states_, origin_states_) * originCovariance(slot);
}

MatrixXd CompressedEkf::jointCovariance(const std::vector<int>& slots) const {
  const auto n = static_cast<Eigen::Index>(slots.size());
  MatrixXd joint(2 * n, 2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      const Matrix2d block =
          covariance(slots[static_cast<std::size_t>(i)], slots[static_cast<std::size_t>(j)]);
      joint.block<2, 2>(2 * i, 2 * j) = block;
      joint.block<2, 2>(2 * j, 2 * i) = block.transpose();
    }
  }
  return joint;
}

void CompressedEkf::predict(const VectorXd& vehicle, const MatrixXd& J, const MatrixXd& Q) {
  const int n = vehicle_states_;
  x_.head(n) = vehicle;
  // Lazy: too small to be worth packing, and there are many between two scans.
  const MatrixXd JP = J.lazyProduct(MatrixXd(symmetric(P_, n)));
  P_.topLeftCorner(n, n) = JP.lazyProduct(J.transpose()) + Q;
  pending_J_ = J.lazyProduct(pending_J_).eval();
  motion_pending_ = true;
}

void CompressedEkf::flushMotion() const {
  if (!motion_pending_) return;
  const int n = vehicle_states_, landmarks = states() - n;
  P_.block(n, 0, landmarks, n) *= pending_J_.transpose();
  phi_.topLeftCorner(n, origin_states_) = pending_J_ * phi_.topLeftCorner(n, origin_states_);
  pending_J_.setIdentity();
  motion_pending_ = false;
}

MatrixXd CompressedEkf::measurementTimesCovariance(const SparseMeasurement& measurement) const {
  const int n = states(), nv = vehicle_states_;
  MatrixXd HP = MatrixXd::Zero(2, n);
  if (measurement.H_vehicle.cols() > 0) {
    HP.leftCols(nv) += measurement.H_vehicle.lazyProduct(MatrixXd(symmetric(P_, nv)));
    HP.rightCols(n - nv) +=
        measurement.H_vehicle.lazyProduct(P_.block(nv, 0, n - nv, nv).transpose());
  }
  for (int k = 0; k < 2; ++k) {
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
  for (int k = 0; k < 2; ++k) {
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
    const MatrixXd HP = a.H_vehicle.lazyProduct(MatrixXd(symmetric(P_, nv)));
    S += HP.lazyProduct(b.H_vehicle.transpose());
  }
  for (int i = 0; i < 2; ++i) {
    if (a.landmarks[i] == SparseMeasurement::kNone) continue;
    const int row = rowOf(a.landmarks[i]);
    if (vehicle_b) S += a.H_landmarks[i] * P_.block(row, 0, 2, nv) * b.H_vehicle.transpose();
  }
  for (int j = 0; j < 2; ++j) {
    if (b.landmarks[j] == SparseMeasurement::kNone) continue;
    const int row = rowOf(b.landmarks[j]);
    if (vehicle_a) {
      S += a.H_vehicle.lazyProduct(P_.block(row, 0, 2, nv).transpose()) *
           b.H_landmarks[j].transpose();
    }
    for (int i = 0; i < 2; ++i) {
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
    for (int k = 0; k < 2; ++k) {
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

std::optional<VectorXd> CompressedEkf::statesAfter(
    const std::vector<SparseMeasurement>& measurements) const {
  const std::optional<Linearised> linearised = linearise(measurements);
  if (!linearised) return std::nullopt;
  const VectorXd weighted =
      linearised->L.triangularView<Eigen::Lower>().transpose().solve(linearised->whitened);
  return x_.head(states()) + linearised->HP.transpose() * weighted;
}

UpdateOutcome CompressedEkf::update(const std::vector<SparseMeasurement>& measurements) {
  if (measurements.empty()) return {};
  std::optional<Linearised> linearised = linearise(measurements);
  if (!linearised) return {std::numeric_limits<double>::quiet_NaN(), 0.0};
  const int m = 2 * static_cast<int>(measurements.size()), n = states(), n0 = origin_states_;
  MatrixXd Hphi(m, n0);
  for (int k = 0; k < m; k += 2) {
    Hphi.middleRows<2>(k) = measurementTimesPhi(measurements[static_cast<std::size_t>(k / 2)]);
  }

  // With S = L * L': every term needs its factors only as L^-1 * (.).
  MatrixXd& HP = linearised->HP;
  const VectorXd& y = linearised->whitened;
  blas::solveLower(m, n, linearised->L.data(), m, HP.data(), m);
  blas::solveLower(m, n0, linearised->L.data(), m, Hphi.data(), m);
  if (landmarks_fixed_) {
    updateVehicle(*linearised, Hphi);
    return {y.squaredNorm(), 0.0};
  }
  const VectorXd correction = HP.transpose() * y;
  x_.head(n) += correction;
  theta_.head(n0) += Hphi.transpose() * y;
  blas::syrkLower(true, n, m, -1.0, HP.data(), m, P_.data(), strideOf(P_));
  blas::syrkLower(true, n0, m, 1.0, Hphi.data(), m, psi_.data(), strideOf(psi_));
  blas::gemm(true, false, n, n0, m, -1.0, HP.data(), m, Hphi.data(), m, phi_.data(),
             strideOf(phi_));

  return {y.squaredNorm(), largestMove(x_.head(n) - correction)};
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

std::vector<int> CompressedEkf::activeLandmarks() const {
  std::vector<int> slots;
  std::copy_if(active_slots_.begin(), active_slots_.end(), std::back_inserter(slots),
               [this](int slot) { return is_place_[static_cast<std::size_t>(slot)]; });
  return slots;
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

int CompressedEkf::append(const Vector2d& position,
                          const Eigen::Matrix<double, 2, Eigen::Dynamic>& G, const Matrix2d& noise,
                          const SlotJacobian& other) {
  flushMotion();
  // As a measurement of zero noise depends on the states, so does the new landmark.
  SparseMeasurement dependence;
  dependence.H_vehicle = G;
  dependence.landmarks[0] = other.slot;
  dependence.H_landmarks[0] = other.G;
  const Matrix2d covariance = innovationCovariance(dependence, dependence) + noise;
  const MatrixXd cross = measurementTimesCovariance(dependence);
  const MatrixXd phi = measurementTimesPhi(dependence);
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

void CompressedEkf::initialiseVehicleStates(int first, const VectorXd& value, const MatrixXd& G,
                                            const MatrixXd& noise) {
  flushMotion();
  const int nv = vehicle_states_, count = static_cast<int>(value.size()), n = states();
  const MatrixXd P_vv = symmetric(P_, nv);
  MatrixXd new_vv = P_vv;
  new_vv.middleRows(first, count) = G * P_vv;
  new_vv.middleCols(first, count) = new_vv.middleRows(first, count).transpose();
  new_vv.block(first, first, count, count) = G * P_vv * G.transpose() + noise;
  const MatrixXd P_lv = P_.block(nv, 0, n - nv, nv);
  P_.topLeftCorner(nv, nv) = new_vv;
  P_.block(nv, first, n - nv, count) = P_lv * G.transpose();
  phi_.block(first, 0, count, origin_states_) = (G * phi_.topLeftCorner(nv, origin_states_)).eval();
  x_.segment(first, count) = value;
}

bool CompressedEkf::globalUpdate() {
  if (store_->isUpdating()) return false;
  IntervalEffect effect = effectSoFar();
  for (const int slot : active_slots_) rows_[static_cast<std::size_t>(slot)] = kPassive;
  free_slots_.insert(free_slots_.end(), retired_slots_.begin(), retired_slots_.end());
  retired_slots_.clear();
  startInterval();
  store_->startUpdate(std::move(effect), hold_updates_ ? PassiveStore::Commitment::kHeld
                                                       : PassiveStore::Commitment::kAtOnce);
  return true;
}

IntervalEffect CompressedEkf::effectSoFar() const {
  flushMotion();
  const int n = states(), n0 = origin_states_;
  IntervalEffect effect;
  effect.origins = origin_indices_;
  for (int row = 0; row < n; ++row) effect.active.push_back(storeIndexOfRow(row));
  effect.phi = phi_.topLeftCorner(n, n0);
  effect.psi = symmetric(psi_, n0);
  effect.theta = theta_.head(n0);
  effect.x = x_.head(n);
  effect.P = symmetric(P_, n);
  effect.size = storeIndex(static_cast<int>(rows_.size()));
  return effect;
}

void CompressedEkf::readLater(const std::vector<int>& slots,
                              std::function<void(const EffectReader&)> job) {
  std::vector<int> indices;
  for (const int slot : slots) indices.push_back(storeIndex(slot));
  store_->runJob(
      [effect = effectSoFar(), held = store_->heldEffect(), indices = std::move(indices),
       job = std::move(job)](const TiledSymmetricMatrix& covariance, const VectorXd& states) {
        if (!held) return job(EffectReader(covariance, states, effect, indices));
        const EffectReader before(covariance, states, *held, neededBefore(effect, indices));
        job(EffectReader(before, effect, indices));
      });
}

int CompressedEkf::storeIndexOfRow(int row) const {
  if (row < vehicle_states_) return row;
  const int offset = row - vehicle_states_;
  return storeIndex(active_slots_[static_cast<std::size_t>(offset / 2)]) + offset % 2;
}

int CompressedEkf::rowOf(int slot) const { return rows_[static_cast<std::size_t>(slot)]; }

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

TwoColumns CompressedEkf::originCovariance(int slot) const {
  return store_->covariance(origin_indices_, storeIndex(slot));
}

TwoColumns CompressedEkf::psiTimes(const TwoColumns& W) const {
  return symmetric(psi_, origin_states_) * W;
}

}  // namespace hymm::core
