#include "supervisor/supervisor_decision.h"

namespace hymm::core {
namespace {

FilterMode computeMode(FilterMode mode, const SupervisorEvidence& evidence) {
  const bool has_pose = evidence.pose_age_s.has_value();
  return mode == FilterMode::kInitialising && has_pose ? FilterMode::kCekf : mode;
}

std::string computeReason(const SupervisorDecision& decision, const SupervisorEvidence& evidence) {
  if (decision.mode == FilterMode::kInitialising) {
    return "No filter has given a pose yet. The first comes with the first scan: do 'scan' (or "
           "'detections') and the motion input arrive at cekf_slam?";
  }
  if (decision.silent) {
    return "The CEKF is in charge, but has given no pose for a while: its inputs have stopped, or "
           "it is paused. See /diagnostics of cekf_slam.";
  }
  if (decision.without_odometry) {
    return "The CEKF is in charge, but map -> odom cannot follow it: " + evidence.odometry_problem;
  }
  return "The CEKF is in charge.";
}

}  // namespace

std::string nameOf(FilterMode mode) {
  switch (mode) {
    case FilterMode::kInitialising:
      return "INITIALISING";
    case FilterMode::kCekf:
      return "CEKF";
    case FilterMode::kRelocalising:
      return "RELOCALISING";
    case FilterMode::kLost:
      break;
  }
  return "LOST";
}

void SupervisorConfig::describe(ConfigSchema& schema) {
  schema.number("tf_rate_hz", tf_rate_hz, Range::between(1.0, 200.0),
                "rate at which map -> odom is broadcast, by the wall");
  schema.number("pose_timeout_s", pose_timeout_s, Range::positive(),
                "a filter that gives no pose for longer is said to be silent, by the wall");
  schema.number("transform_wait_s", transform_wait_s, Range::between(0.0, 60.0),
                "longest wait for odom -> base_link at a pose's stamp, by the wall");
  schema.number("trajectory_spacing_m", trajectory_spacing_m, Range::notNegative(),
                "least way between two poses of `trajectory`");
  schema.number("trajectory_rate_hz", trajectory_rate_hz, Range{0.0, 100.0, true},
                "highest rate of `trajectory`, by the wall");
  schema.integer("trajectory_max_poses", trajectory_max_poses, Range::between(10, 1000000),
                 "beyond that many, every other pose of `trajectory` is left out");
}

SupervisorEvidence evidenceAtScan(const FilterHealth& health) {
  SupervisorEvidence evidence;
  evidence.pose_age_s = 0.0;
  evidence.nis = health.nis;
  evidence.dof = health.dof;
  evidence.ambiguity = health.ambiguity;
  evidence.unexplained = health.unexplained;
  evidence.missed = health.missed;
  return evidence;
}

SupervisorDecision computeDecision(FilterMode mode, const SupervisorEvidence& evidence,
                                   const SupervisorConfig& config) {
  SupervisorDecision decision;
  decision.mode = computeMode(mode, evidence);
  decision.silent = evidence.pose_age_s && *evidence.pose_age_s > config.pose_timeout_s;
  decision.without_odometry = evidence.pose_age_s && !evidence.odometry_known;
  decision.reason = computeReason(decision, evidence);
  if (evidence.pose_age_s) {
    decision.figures = {{"pose_age_s", *evidence.pose_age_s, config.pose_timeout_s},
                        {"nis_per_dof", evidence.dof > 0 ? evidence.nis / evidence.dof : 0.0, {}},
                        {"ambiguity", evidence.ambiguity, {}},
                        {"unexplained", evidence.unexplained, {}},
                        {"missed", evidence.missed, {}}};
  }
  return decision;
}

bool isModeSwitch(FilterMode before, FilterMode after) {
  return after != before && before != FilterMode::kInitialising;
}

}  // namespace hymm::core
