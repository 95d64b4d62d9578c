#include "cekf/local_state.h"

#include "cekf/compressed_ekf.h"

namespace hymm::core {

LocalState CompressedEkf::localState() const {
  LocalState state;
  state.active_slots = active_slots_;
  state.x = x_;
  state.P = P_;
  state.phi = phi_;
  state.psi = psi_;
  state.theta = theta_;
  state.origin_indices = origin_indices_;
  state.origin_states = origin_states_;
  state.pending_J = pending_J_;
  state.motion_pending = motion_pending_;
  state.rows = rows_;
  state.is_place = is_place_;
  state.free_slots = free_slots_;
  state.retired_slots = retired_slots_;
  state.landmark_count = landmark_count_;
  state.updates_released = store_->updatesReleased();
  state.held = store_->heldEffect();
  return state;
}

bool CompressedEkf::canGoBackTo(const LocalState& state) const {
  const std::size_t since = store_->updatesReleased() - state.updates_released;
  return since == 0 || (since == 1 && state.held);
}

bool CompressedEkf::goBackTo(const LocalState& state) {
  if (!canGoBackTo(state)) return false;
  store_->discardUpdate();
  const bool still_held = store_->updatesReleased() == state.updates_released;
  if (state.held && still_held) {
    store_->startUpdate(*state.held, PassiveStore::Commitment::kHeld);
  }
  active_slots_ = state.active_slots;
  x_ = state.x;
  P_ = state.P;
  phi_ = state.phi;
  psi_ = state.psi;
  theta_ = state.theta;
  origin_indices_ = state.origin_indices;
  origin_states_ = state.origin_states;
  pending_J_ = state.pending_J;
  motion_pending_ = state.motion_pending;
  rows_ = state.rows;
  is_place_ = state.is_place;
  free_slots_ = state.free_slots;
  retired_slots_ = state.retired_slots;
  landmark_count_ = state.landmark_count;
  return true;
}

}  // namespace hymm::core
