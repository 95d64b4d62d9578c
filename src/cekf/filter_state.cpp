/// What is saved of the filter's own state, and how it is checked when it comes back. The interval
/// since the last global update is saved as it is: a filter that goes on from here computes the
/// same bits as one that never stopped.
#include <algorithm>
#include <memory>
#include <utility>

#include "cekf/compressed_ekf.h"
#include "cekf/vehicle_state.h"
#include "common/state_archive.h"

namespace hymm::core {
namespace {

using Eigen::VectorXd;

// Spare capacity that is taken over from a file.
constexpr Eigen::Index kMostSpare = 4096;

constexpr int kTile = TiledSymmetricMatrix::kTileSize;
constexpr std::size_t kTileBytes = sizeof(double) * kTile * kTile;

bool areBelow(const std::vector<int>& values, std::size_t end) {
  return std::all_of(values.begin(), values.end(),
                     [end](int v) { return v >= 0 && static_cast<std::size_t>(v) < end; });
}

/// Whether the effect's parts fit each other; its origins are among the states that are stored, or
/// the vehicle's, which need not be yet.
bool isConsistent(const IntervalEffect& effect, int stored) {
  const auto n = static_cast<Eigen::Index>(effect.active.size());
  const auto n0 = static_cast<Eigen::Index>(effect.origins.size());
  const bool fits = effect.phi.rows() == n && effect.phi.cols() == n0 && effect.psi.rows() == n0 &&
                    effect.psi.cols() == n0 && effect.theta.size() == n0 && effect.x.size() == n &&
                    effect.P.rows() == n && effect.P.cols() == n;
  const auto end = static_cast<std::size_t>(std::max(stored, effect.size));
  constexpr int kMostNew = 8192;  // states since the update before
  return fits && effect.size > 0 && effect.size <= stored + kMostNew &&
         areBelow(effect.active, end) && areBelow(effect.origins, end);
}

template <class Archive>
void describeInput(Archive& archive, MotionInput& input) {
  bool is_twist = std::holds_alternative<TwistInput>(input);
  archive(is_twist);
  if constexpr (Archive::kReads) input = is_twist ? MotionInput(TwistInput{}) : AckermannInput{};
  if (auto* twist = std::get_if<TwistInput>(&input)) {
    archive(twist->time_s, twist->forward_mps, twist->lateral_mps, twist->yaw_rate_radps,
            twist->density);
  } else {
    auto& car = std::get<AckermannInput>(input);
    archive(car.time_s, car.speed_mps, car.steering_rad);
  }
}

}  // namespace

void TiledSymmetricMatrix::save(StateWriter& archive) const {
  archive(static_cast<std::uint64_t>(tile_rows_));
  for (const Tile& tile : tiles_) archive.putRaw(tile.get(), kTileBytes);
}

void TiledSymmetricMatrix::restore(StateReader& archive) {
  const std::size_t rows = archive.readSize(kTileBytes);
  std::vector<Tile> tiles;
  for (std::size_t i = 0; i < rows * (rows + 1) / 2; ++i) {
    tiles.push_back(newTile());
    archive.getRaw(tiles.back().get(), kTileBytes);
  }
  tile_rows_ = rows;
  tiles_ = std::move(tiles);
}

/// A held update stays held: it is saved beside what it has not changed yet.
void PassiveStore::save(StateWriter& archive) {
  if (!held_) finish();
  worker_.wait();
  tiles_.save(archive);
  archive(*states_, *variances_, static_cast<std::uint64_t>(updates_done_), held_ != nullptr);
  if (held_) archive(*held_);
}

void PassiveStore::restore(StateReader& archive) {
  finish();
  tiles_.restore(archive);
  const auto states = std::make_shared<VectorXd>();
  const auto variances = std::make_shared<VectorXd>();
  archive(*states, *variances);
  archive.require(states->size() == tiles_.size() && variances->size() == tiles_.size(),
                  "its states and their covariance differ in size");
  states_ = worker_states_ = states;
  variances_ = variances;
  updates_done_ = static_cast<std::size_t>(archive.read<std::uint64_t>());
  if (!archive.read<bool>()) return;
  auto effect = archive.read<IntervalEffect>();
  archive.require(isConsistent(effect, tiles_.size()), "its last global update cannot be");
  startUpdate(std::move(effect), Commitment::kAtOnce);
  finish();
}

void CompressedEkf::save(StateWriter& archive) {
  archive(vehicle_states_);
  store_->save(archive);
  describeInterval(archive);
}

void CompressedEkf::restore(StateReader& archive) {
  const auto vehicle_states = archive.read<int>();
  archive.requireSame(vehicle_states == vehicle_states_,
                      "it holds " + std::to_string(vehicle_states) +
                          " states of the vehicle, the configuration makes " +
                          std::to_string(vehicle_states_) +
                          "; start with the parameters of the vehicle that it was saved with.");
  store_->restore(archive);
  describeInterval(archive);
  checkRestored(archive);
}

template <class Archive>
void CompressedEkf::describeInterval(Archive& archive) {
  // With the same spare capacity everything lies as it lay, for sums that go by alignment.
  Eigen::Index rows = x_.size(), columns = theta_.size();
  archive(active_slots_, origin_indices_, rows, columns);
  const auto n = static_cast<Eigen::Index>(vehicle_states_ + 2 * active_slots_.size());
  const auto n0 = static_cast<Eigen::Index>(origin_indices_.size());
  if constexpr (Archive::kReads) {
    archive.requireBytes(static_cast<std::size_t>(n * (n + 1) / 2 + n0 * n) * sizeof(double));
    rows = std::max(n, std::min(rows, kMostSpare));
    columns = std::max(n0, std::min(columns, kMostSpare));
    origin_states_ = static_cast<int>(n0);
    x_.setZero(rows);
    P_.setZero(rows, rows);
    phi_.setZero(rows, columns);
    psi_.setZero(columns, columns);
    theta_.setZero(columns);
  }
  VectorXd x = x_.head(n), theta = theta_.head(n0);
  archive(x, theta);
  if constexpr (Archive::kReads) {
    archive.require(x.size() == n && theta.size() == n0, "its active states differ in size");
    x_.head(n) = x;
    theta_.head(n0) = theta;
  }
  describeLower(archive, P_, static_cast<int>(n));
  describeBlock(archive, phi_, static_cast<int>(n), static_cast<int>(n0));
  describeLower(archive, psi_, static_cast<int>(n0));
  archive(pending_J_, motion_pending_, rows_, is_place_, free_slots_, retired_slots_);
}

/// What the rest relies on without looking: every index points to where something is.
void CompressedEkf::checkRestored(StateReader& archive) {
  const bool has_motion =
      pending_J_.rows() == vehicle_states_ && pending_J_.cols() == vehicle_states_;
  archive.require(has_motion, "its last motion is of other states");
  const std::size_t slots = rows_.size();
  archive.require(is_place_.size() == slots && areBelow(active_slots_, slots) &&
                      areBelow(free_slots_, slots) && areBelow(retired_slots_, slots),
                  "a landmark's slot does not exist");
  std::vector<int> expected(slots, kFree);
  const auto stored = static_cast<std::size_t>(store_->states().size());
  landmark_count_ = 0;
  for (std::size_t slot = 0; slot < slots; ++slot) {
    const bool is_free = rows_[slot] == kFree;
    archive.require(is_free || rows_[slot] >= kPassive, "a landmark's state does not exist");
    if (!is_free && is_place_[slot]) ++landmark_count_;
    const auto end = static_cast<std::size_t>(storeIndex(static_cast<int>(slot))) + 2;
    if (rows_[slot] == kPassive) {
      expected[slot] = kPassive;
      archive.require(end <= stored, "a landmark's state was not stored");
    }
  }
  for (std::size_t k = 0; k < active_slots_.size(); ++k) {
    int& row = expected[static_cast<std::size_t>(active_slots_[k])];
    archive.require(row == kFree, "a landmark is active twice");
    row = vehicle_states_ + 2 * static_cast<int>(k);
  }
  archive.require(expected == rows_, "its active landmarks contradict each other");
  for (const std::vector<int>* free : {&free_slots_, &retired_slots_}) {
    for (const int slot : *free) {
      archive.require(expected[static_cast<std::size_t>(slot)] == kFree, "a slot is free and used");
      expected[static_cast<std::size_t>(slot)] = kFree - 1;  // each once
    }
  }
  checkOrigins(archive, stored);
}

void CompressedEkf::checkOrigins(StateReader& archive, std::size_t stored) const {
  archive.require(origin_indices_.size() >= static_cast<std::size_t>(vehicle_states_),
                  "its interval does not begin with the vehicle");
  for (int k = 0; k < vehicle_states_; ++k) {
    archive.require(origin_indices_[static_cast<std::size_t>(k)] == k,
                    "its interval does not begin with the vehicle");
  }
  const bool only_the_vehicle = origin_indices_.size() == static_cast<std::size_t>(vehicle_states_);
  archive.require(only_the_vehicle || areBelow(origin_indices_, stored),
                  "its interval begins with states that were not stored");
}

template <class Archive>
void VehicleState::describeState(Archive& archive) {
  archive(linearised_at_);
  describeInput(archive, input_);
  archive(has_input_, started_, in_gap_, time_s_);
  archive(motion_noise_, noise_scale_, earlier_readings_);
}

void VehicleState::save(StateWriter& archive) {
  archive(size_, calibration_index_, laser_yaw_.index, laser_range_.index, laser_time_.index,
          gps_datum_index_);
  describeState(archive);
}

void VehicleState::restore(StateReader& archive) {
  bool is_same = archive.read<int>() == size_;
  for (const int index : calibration_index_) is_same = is_same & (archive.read<int>() == index);
  for (const LaserError& error : {laser_yaw_, laser_range_, laser_time_}) {
    is_same = is_same & (archive.read<int>() == error.index);
  }
  is_same = is_same & (archive.read<int>() == gps_datum_index_);
  archive.requireSame(
      is_same,
      "other calibration values were estimated, or GPS was fused in one and not in "
      "the other; start with the vehicle and gps parameters that it was saved with.");
  describeState(archive);
}

}  // namespace hymm::core
