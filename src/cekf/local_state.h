#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "cekf/interval_effect.h"

namespace hymm::core {

/// All of a CompressedEkf at one moment but what its global updates have carried out: the vehicle
/// and the active landmarks, with phi, psi and theta. Members are as in the filter, spare capacity
/// included, so that what follows from them does so to the bit.
struct LocalState {
  std::vector<int> active_slots;
  Eigen::VectorXd x;
  Eigen::MatrixXd P, phi, psi;
  Eigen::VectorXd theta;
  std::vector<int> origin_indices;
  int origin_states = 0;
  Eigen::MatrixXd pending_J;
  bool motion_pending = false;
  std::vector<int> rows;
  std::vector<bool> is_place;
  std::vector<int> free_slots, retired_slots;
  std::size_t landmark_count = 0;
  /// Global updates released so far, and what the one does that is held, if there is one.
  std::size_t updates_released = 0;
  std::shared_ptr<const IntervalEffect> held;

  std::size_t bytes() const {
    const Eigen::Index numbers = x.size() + P.size() + phi.size() + psi.size() + theta.size();
    return static_cast<std::size_t>(numbers) * sizeof(double);
  }
};

}  // namespace hymm::core
