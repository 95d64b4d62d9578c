#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cekf/cekf_slam.h"
#include "common/config.h"

namespace hymm::core {

/// Which filter is in charge of the pose.
enum class FilterMode { kInitialising, kCekf, kRelocalising, kLost };

/// As FilterStatus and health.csv spell it.
std::string nameOf(FilterMode mode);

/// Parameters of the node `supervisor`, as config/supervisor.yaml documents them.
struct SupervisorConfig {
  double tf_rate_hz = 30.0;            ///< of map -> odom
  double pose_timeout_s = 2.0;         ///< by the wall: longest silence of a filter that is well
  double transform_wait_s = 1.0;       ///< by the wall: longest wait for odom -> base_link
  double trajectory_spacing_m = 0.25;  ///< between poses of `trajectory`
  double trajectory_rate_hz = 1.0;     ///< highest rate of `trajectory`
  int trajectory_max_poses = 20000;    ///< beyond that every other pose goes

  void describe(ConfigSchema& schema);
};

/// What the decision rests on, at one moment.
struct SupervisorEvidence {
  std::optional<double>
      pose_age_s;    ///< wall time since the last pose of the CEKF; nothing: none yet
  double nis = 0.0;  ///< of its last scan
  int dof = 0;
  double ambiguity = 0.0;  ///< shares of its last scan, see FilterHealth
  double unexplained = 0.0;
  double missed = 0.0;
  bool odometry_known = true;    ///< whether tf tells odom -> base_link at the last pose
  std::string odometry_problem;  ///< if not: what tf says
};

/// The evidence at the moment in which the CEKF has taken a scan.
SupervisorEvidence evidenceAtScan(const FilterHealth& health);

/// One figure that a decision rests on, as it is told.
struct EvidenceFigure {
  std::string name;
  double value = 0.0;
  std::optional<double> limit;  ///< nothing: told only
};

struct SupervisorDecision {
  FilterMode mode = FilterMode::kInitialising;
  bool silent = false;            ///< the filter in charge gives no poses
  bool without_odometry = false;  ///< map -> odom cannot follow it
  std::string reason;
  std::vector<EvidenceFigure> figures;
};

/// Who is in charge next, given who is now. Pure: the same arguments, the same decision. With one
/// filter to choose from, the health figures are told but decide nothing yet.
SupervisorDecision computeDecision(FilterMode mode, const SupervisorEvidence& evidence,
                                   const SupervisorConfig& config);

/// Whether the mode was switched: that a run begins in its first mode is no switch.
bool isModeSwitch(FilterMode before, FilterMode after);

}  // namespace hymm::core
