#include "cekf/compressed_ekf.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <stdexcept>
#include <string>
#include <unordered_set>

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;
using TwoColumns = Eigen::Matrix<double, Eigen::Dynamic, 2>;

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

VehicleMatrix CompressedEkf::vehicleCovariance() const {
  const int n = vehicle_states_;
  VehicleMatrix covariance(n, n);
  for (int j = 0; j < n; ++j) {
    for (int i = j; i < n; ++i) covariance(i, j) = covariance(j, i) = P_(i, j);
  }
  return covariance;
}

MatrixXd CompressedEkf::activeCovariance() const {
  flushMotion();
  return symmetric(P_, states());
}

Vector2d CompressedEkf::landmark(int slot) const {
  const int row = rowOf(slot);
  if (row >= 0) return x_.segment<2>(row);
  return store_->state(storeIndex(slot)) +
         originCovariance(slot).transpose() * theta_.head(origin_states_);
}

Matrix2d CompressedEkf::covariance(int slot_a, int slot_b) const {
  flushMotion();
  const int row_a = rowOf(slot_a), row_b = rowOf(slot_b);
  if (row_a >= 0 && row_b >= 0) return covarianceOfRows(row_a, row_b);
  if (row_a >= 0) return phi_.block(row_a, 0, 2, origin_states_) * originCovariance(slot_b);
  if (row_b >= 0) return covariance(slot_b, slot_a).transpose();
  const int index_a = storeIndex(slot_a);
  const Matrix2d block = store_->covariance({index_a, index_a + 1}, storeIndex(slot_b));
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

void CompressedEkf::predict(const VehicleVector& vehicle, const VehicleMatrix& J,
                            const VehicleMatrix& Q) {
  const int n = vehicle_states_;
  x_.head(n) = vehicle;
  const VehicleMatrix JP = timesMotionTransposed(vehicleCovariance(), J).transpose();
  P_.topLeftCorner(n, n) = timesMotionTransposed(JP, J) + Q;
  const VehicleMatrix before = pending_J_.transpose();
  pending_J_ = timesMotionTransposed(before, J).transpose();
  motion_pending_ = true;
}

void CompressedEkf::flushMotion() const {
  if (!motion_pending_) return;
  const int n = vehicle_states_, landmarks = states() - n;
  const VehicleMatrix J = pending_J_;
  P_.block(n, 0, landmarks, n) = timesMotionTransposed(P_.block(n, 0, landmarks, n), J);
  phi_.topLeftCorner(n, origin_states_) =
      timesMotionTransposed(phi_.topLeftCorner(n, origin_states_).transpose(), J).transpose();
  pending_J_.setIdentity();
  motion_pending_ = false;
}

std::vector<int> CompressedEkf::activeLandmarks() const {
  std::vector<int> slots;
  std::copy_if(active_slots_.begin(), active_slots_.end(), std::back_inserter(slots),
               [this](int slot) { return is_place_[static_cast<std::size_t>(slot)]; });
  return slots;
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

TwoColumns CompressedEkf::originCovariance(int slot) const {
  return store_->covariance(origin_indices_, storeIndex(slot));
}

TwoColumns CompressedEkf::psiTimes(const TwoColumns& W) const {
  return symmetric(psi_, origin_states_) * W;
}

}  // namespace hymm::core
