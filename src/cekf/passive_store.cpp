#include "cekf/passive_store.h"

#include <algorithm>
#include <utility>

#include "cekf/blas.h"

namespace hymm::core {
namespace {

using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr int kTile = TiledSymmetricMatrix::kTileSize;
constexpr int kPassive = -1;

int rowsOf(const MatrixXd& matrix) { return static_cast<int>(matrix.rows()); }

/// F' * W.
MatrixXd transposedProduct(const MatrixXd& F, const MatrixXd& W) {
  MatrixXd product = MatrixXd::Zero(F.cols(), W.cols());
  blas::gemm(true, false, static_cast<int>(F.cols()), static_cast<int>(W.cols()), rowsOf(F), 1.0,
             F.data(), rowsOf(F), W.data(), rowsOf(W), product.data(), rowsOf(product));
  return product;
}

/// An active state within a tile's rows or columns.
struct ActiveEntry {
  int offset;
  int row;  ///< of the active part
};

std::vector<std::vector<ActiveEntry>> activeByTile(const IntervalEffect& effect, int tile_rows) {
  std::vector<std::vector<ActiveEntry>> entries(static_cast<std::size_t>(tile_rows));
  for (std::size_t row = 0; row < effect.active.size(); ++row) {
    const int index = effect.active[row];
    entries[static_cast<std::size_t>(index / kTile)].push_back(
        {index % kTile, static_cast<int>(row)});
  }
  return entries;
}

/// tile <- tile - T_i' * T_j, the columns of T being those of the tile's rows and columns; of a
/// tile on the diagonal, the lower triangle.
void subtractProduct(const MatrixXd& T, int i, int j, double* tile) {
  const int rank = rowsOf(T);
  const double* T_i = T.data() + static_cast<std::ptrdiff_t>(i) * kTile * rank;
  const double* T_j = T.data() + static_cast<std::ptrdiff_t>(j) * kTile * rank;
  if (i == j) {
    blas::syrkLower(true, kTile, rank, -1.0, T_i, rank, tile, kTile);
  } else {
    blas::gemm(true, false, kTile, kTile, rank, -1.0, T_i, rank, T_j, rank, tile, kTile);
  }
}

}  // namespace

PassiveStore::PassiveStore(SerialWorker::Mode mode)
    : states_(std::make_shared<VectorXd>()),
      variances_(states_),
      worker_states_(states_),
      worker_(mode) {}

int PassiveStore::Update::activeRow(int index) const {
  const auto found = active_rows.find(index);
  return found == active_rows.end() ? kPassive : found->second;
}

bool PassiveStore::Update::isTileNew(int a, int b) const {
  const int row = std::max(a, b) / kTile, column = std::min(a, b) / kTile;
  return row < tile_rows_done || (row == tile_rows_done && column < tiles_done_in_row);
}

void PassiveStore::startUpdate(IntervalEffect effect, Commitment commitment) {
  if (commitment == Commitment::kHeld) held_ = std::make_shared<const IntervalEffect>(effect);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    update_.emplace(Update{});
    for (std::size_t row = 0; row < effect.active.size(); ++row) {
      update_->active_rows[effect.active[row]] = static_cast<int>(row);
    }
    update_->effect = std::move(effect);
  }
  if (commitment == Commitment::kAtOnce) carryOutLater();
}

void PassiveStore::carryOutLater() {
  ++updates_released_;
  worker_.run([this] { carryOut(*update_); });
  isUpdating();
}

void PassiveStore::releaseUpdate() {
  if (!held_) return;
  held_.reset();
  carryOutLater();
}

void PassiveStore::discardUpdate() {
  if (!held_) return;
  held_.reset();
  const std::lock_guard<std::mutex> lock(mutex_);
  update_.reset();
}

bool PassiveStore::isUpdating() {
  if (!update_) return false;
  const bool worker_is_idle = worker_.pending() == 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (update_->done) {
      states_ = update_->states;
      variances_ = update_->variances;
      ++updates_done_;
      update_.reset();
      return false;
    }
  }
  if (worker_is_idle) worker_.wait();  // throws what kept it from being done
  return true;
}

void PassiveStore::finish() {
  releaseUpdate();
  worker_.wait();
  isUpdating();
}

void PassiveStore::runJob(Job job) {
  worker_.run([this, job = std::move(job)] {
    if (!abandoned_) job(tiles_, *worker_states_);
  });
}

Vector2d PassiveStore::state(int index) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!update_) return states_->segment<2>(index);
  const int row = update_->activeRow(index);
  if (row != kPassive) return update_->effect.x.segment<2>(row);
  if (update_->gathered) return update_->states->segment<2>(index);
  const VectorXd& theta = update_->effect.theta;
  return states_->segment<2>(index) +
         Vector2d(originRow(index).dot(theta), originRow(index + 1).dot(theta));
}

PassiveStore::TwoColumns PassiveStore::covariance(const std::vector<int>& rows, int index) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (update_ && !update_->done) return covarianceDuringUpdate(rows, index);
  TwoColumns result(static_cast<Eigen::Index>(rows.size()), 2);
  for (Eigen::Index k = 0; k < result.rows(); ++k) {
    const int row = rows[static_cast<std::size_t>(k)];
    result.row(k) << tiles_(row, index), tiles_(row, index + 1);
  }
  return result;
}

PassiveStore::TwoColumns PassiveStore::covarianceDuringUpdate(const std::vector<int>& rows,
                                                              int index) const {
  const IntervalEffect& effect = update_->effect;
  const int column = update_->activeRow(index);
  TwoColumns W(effect.theta.size(), 2);  // cov(origins, the pair), if that is passive
  TwoColumns coefficients;               // what rows of W are multiplied with
  if (column != kPassive) {
    coefficients = effect.phi.middleRows<2>(column).transpose();
  } else {
    W << originRow(index).transpose(), originRow(index + 1).transpose();
    coefficients = effect.psi * W;
  }

  TwoColumns result(static_cast<Eigen::Index>(rows.size()), 2);
  for (Eigen::Index k = 0; k < result.rows(); ++k) {
    const int other = rows[static_cast<std::size_t>(k)];
    const int row = update_->activeRow(other);
    if (row != kPassive && column != kPassive) {
      result.row(k) = effect.P.block<1, 2>(row, column);
    } else if (row != kPassive) {
      result.row(k) = effect.phi.row(row) * W;
    } else if (column != kPassive) {
      result.row(k) = originRow(other) * coefficients;
    } else {
      result.row(k) << tiles_(other, index), tiles_(other, index + 1);
      if (!update_->isTileNew(other, index)) result.row(k) -= originRow(other) * coefficients;
    }
  }
  return result;
}

RowVectorXd PassiveStore::originRow(int index) const {
  if (update_->gathered) return update_->W.col(index).transpose();
  const auto known = update_->rows.find(index);
  if (known != update_->rows.end()) return known->second;
  const std::vector<int>& origins = update_->effect.origins;
  RowVectorXd row(static_cast<Eigen::Index>(origins.size()));
  for (Eigen::Index k = 0; k < row.size(); ++k) {
    row[k] = tiles_(index, origins[static_cast<std::size_t>(k)]);
  }
  return update_->rows[index] = row;
}

void PassiveStore::carryOut(Update& update) {
  growTo(update.effect.size);
  gather(update);
  replaceTiles(update);
}

void PassiveStore::growTo(int size) {
  std::vector<TiledSymmetricMatrix::Tile> fresh(tiles_.tilesToGrow(size));
  for (auto& tile : fresh) tile = TiledSymmetricMatrix::newTile();
  const std::lock_guard<std::mutex> lock(mutex_);
  tiles_.grow(size, std::move(fresh));
}

void PassiveStore::gather(Update& update) {
  const IntervalEffect& effect = update.effect;
  const auto origins = static_cast<Eigen::Index>(effect.origins.size());
  MatrixXd W(origins, tiles_.size());
  MatrixXd columns(kTile, origins);
  for (int tile_row = 0; tile_row < tiles_.tileRows(); ++tile_row) {
    for (Eigen::Index k = 0; k < origins; ++k) {
      tiles_.copyTileColumn(tile_row, effect.origins[static_cast<std::size_t>(k)],
                            columns.col(k).data());
    }
    W.middleCols<kTile>(tile_row * kTile) = columns.transpose();
  }

  VectorXd states = VectorXd::Zero(tiles_.size());
  states.head(worker_states_->size()) = *worker_states_;
  states += W.transpose() * effect.theta;
  for (std::size_t row = 0; row < effect.active.size(); ++row) {
    states[effect.active[row]] = effect.x[static_cast<Eigen::Index>(row)];
  }

  auto shared_states = std::make_shared<const VectorXd>(std::move(states));
  const std::lock_guard<std::mutex> lock(mutex_);
  update.W = std::move(W);
  update.states = std::move(shared_states);
  update.gathered = true;
}

void PassiveStore::replaceTiles(Update& update) {
  const IntervalEffect& effect = update.effect;
  const MatrixXd T = transposedProduct(factorOf(effect.psi), update.W);
  MatrixXd P_active_all = transposedProduct(effect.phi.transpose(), update.W);
  for (std::size_t row = 0; row < effect.active.size(); ++row) {
    P_active_all.col(effect.active[row]) = effect.P.col(static_cast<Eigen::Index>(row));
  }
  const auto active = activeByTile(effect, tiles_.tileRows());

  VectorXd variances(tiles_.size());
  TiledSymmetricMatrix::Tile fresh = TiledSymmetricMatrix::newTile();
  for (int i = 0; i < tiles_.tileRows() && !abandoned_; ++i) {
    for (int j = 0; j <= i; ++j) {
      std::copy_n(tiles_.tile(i, j), kTile * kTile, fresh.get());
      subtractProduct(T, i, j, fresh.get());
      Eigen::Map<Eigen::Matrix<double, kTile, kTile>> tile(fresh.get());
      for (const ActiveEntry& entry : active[static_cast<std::size_t>(j)]) {
        tile.col(entry.offset) = P_active_all.row(entry.row).segment<kTile>(i * kTile).transpose();
      }
      for (const ActiveEntry& entry : active[static_cast<std::size_t>(i)]) {
        tile.row(entry.offset) = P_active_all.row(entry.row).segment<kTile>(j * kTile);
      }
      if (i == j) variances.segment<kTile>(i * kTile) = tile.diagonal();
      const std::lock_guard<std::mutex> lock(mutex_);
      tiles_.exchangeTile(i, j, fresh);
      update.tiles_done_in_row = j + 1;
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    update.tile_rows_done = i + 1;
    update.tiles_done_in_row = 0;
  }

  if (abandoned_) return;
  auto shared_variances = std::make_shared<const VectorXd>(std::move(variances));
  worker_states_ = update.states;
  MatrixXd W;  // large: better freed here than by whoever finds the update done
  const std::lock_guard<std::mutex> lock(mutex_);
  W.swap(update.W);
  update.variances = std::move(shared_variances);
  update.done = true;
}

}  // namespace hymm::core
