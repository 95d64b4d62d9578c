#pragma once

#include <cmath>

#include "supervisor/supervisor_decision.h"

namespace hymm::core {

inline constexpr double kNow_s = 100.0;
inline constexpr double kPeriod_s = 0.2;  // of scans

/// Suspicious scans that last so long, one after the other.
inline int scansOver(double duration_s, double period_s = kPeriod_s) {
  return static_cast<int>(std::lround(duration_s / period_s));
}

inline SupervisorState stateIn(FilterMode mode, int attempts = 0) {
  SupervisorState state;
  state.mode = mode;
  state.since_s = kNow_s - 1.0;
  state.attempts = attempts;
  state.good_order_s = kNow_s - kPeriod_s;
  return state;
}

/// A scan that the CEKF explains well.
inline SupervisorEvidence healthy() {
  SupervisorEvidence evidence;
  evidence.time_s = kNow_s;
  evidence.pose_age_s = 0.0;
  evidence.new_scan = true;
  evidence.scan.nis = 10.0;
  evidence.scan.dof = 10;
  return evidence;
}

inline SupervisorEvidence ambiguous() {
  SupervisorEvidence evidence = healthy();
  evidence.scan.ambiguity = 0.9;
  evidence.scan.old_landmarks_expected = 3;
  return evidence;
}

using Search = RelocaliserEvidence::State;

inline SupervisorEvidence withRelocaliser(SupervisorEvidence evidence,
                                          Search state = Search::kSearching) {
  evidence.relocaliser = RelocaliserEvidence{0.1, state, "there is more than one mode"};
  return evidence;
}

/// The state after `scans` scans of the same kind.
inline SupervisorDecision afterScans(SupervisorState state, SupervisorEvidence evidence, int scans,
                                     const SupervisorConfig& config = {},
                                     double period_s = kPeriod_s) {
  SupervisorDecision decision;
  decision.state = state;
  for (int i = 0; i < scans; ++i) {
    decision = computeDecision(decision.state, evidence, config);
    evidence.time_s += period_s;
  }
  return decision;
}

}  // namespace hymm::core
