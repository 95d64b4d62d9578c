#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cekf/cekf_slam.h"
#include "common/config.h"
#include "supervisor/loss_test.h"
#include "supervisor/old_landmarks.h"
#include "supervisor/suspicion.h"

namespace hymm::core {

/// Which filter is in charge of the pose.
enum class FilterMode { kInitialising, kCekf, kRelocalising, kLost };

/// As FilterStatus and health.csv spell it.
std::string nameOf(FilterMode mode);

/// How long doubt has to last, and how often the relocaliser is asked.
struct SwitchingConfig {
  bool automatic = true;                 ///< else only by order; doubt is told either way
  bool automatic_by_detections = false;  ///< the same where no scans are taken
  double suspicious_s = 2.0;             ///< by stamps, since the last scan in good order
  double armed_suspicious_s = 0.6;       ///< the same while the deviation is large
  double relocalise_timeout_s = 30.0;    ///< longest attempt
  double retry_interval_s = 10.0;        ///< between attempts
  int max_attempts = 3;                  ///< then on with the CEKF, without closing the loop
  double rest_s = 20.0;                  ///< after the CEKF took over again
  double longest_doubt_s = 15.0;         ///< T0 is no longer ago

  void describe(ConfigSchema& schema);
};

/// Parameters of the node `supervisor`, as config/supervisor.yaml documents them.
struct SupervisorConfig {
  double tf_rate_hz = 30.0;            ///< of map -> odom
  double pose_timeout_s = 2.0;         ///< by the wall: longest silence of a filter that is well
  double transform_wait_s = 1.0;       ///< by the wall: longest wait for odom -> base_link
  double trajectory_spacing_m = 0.25;  ///< between poses of `trajectory`
  double trajectory_rate_hz = 1.0;     ///< highest rate of `trajectory`
  int trajectory_max_poses = 20000;    ///< beyond that every other pose goes
  SuspicionConfig suspicion;
  LossTestConfig loss;
  OldLandmarkConfig old_landmarks;
  SwitchingConfig switching;

  void describe(ConfigSchema& schema);
};

/// What the relocaliser says.
struct RelocaliserEvidence {
  enum class State {
    kSearching,  ///< or not asked
    kAccepted,   ///< it found the place, and the CEKF took it over
    kRefused,    ///< it found a place, and the CEKF refused it
    kFailed,     ///< it could not begin
  };

  double age_s = 0.0;  ///< wall time since it last said something
  State state = State::kSearching;
  std::string reason;  ///< why it has not found the place, or what was said
};

/// What the decision rests on, at one moment.
struct SupervisorEvidence {
  double time_s = 0.0;  ///< of the recording
  std::optional<double>
      pose_age_s;              ///< wall time since the last pose of the CEKF; nothing: none yet
  bool new_scan = false;       ///< whether `scan` has not been judged before
  ScanEvidence scan;           ///< the CEKF's last
  bool of_detections = false;  ///< that scan is a set of `detections`: what was hidden is not known
  bool waits = false;          ///< the CEKF was suspended for a search when it took that scan
  std::optional<RelocaliserEvidence> relocaliser;  ///< nothing: it does not run
  std::optional<FilterMode> requested;             ///< by an operator: kCekf or kRelocalising
  bool odometry_known = true;    ///< whether tf tells odom -> base_link at the last pose
  std::string odometry_problem;  ///< if not: what tf says
};

/// The evidence at the moment in which the CEKF has taken a scan; what others say is left to fill
/// in.
SupervisorEvidence evidenceAtScan(const FilterHealth& health);

/// One figure that a decision rests on, as it is told.
struct EvidenceFigure {
  std::string name;
  double value = 0.0;
  std::optional<double> limit;  ///< nothing: told only
};

/// What the supervisor remembers from one decision to the next.
struct SupervisorState {
  FilterMode mode = FilterMode::kInitialising;
  double since_s = 0.0;               ///< when the mode began
  int suspicious_scans = 0;           ///< in a row, the last of them
  int attempts = 0;                   ///< to relocalise since the CEKF was last in good order
  double not_before_s = 0.0;          ///< when the next attempt may begin
  double good_order_s = 0.0;          ///< stamp of the last scan of the CEKF that left no doubt: T0
  double suspicious_s = 0.0;          ///< that suspicion has lasted for, gaps in the scans left out
  std::optional<double> last_scan_s;  ///< of the CEKF
  LossTest loss;
  std::optional<double> waits_from_s;    ///< since when the CEKF waits though it is in charge
  std::optional<double> doubted_from_s;  ///< scan before which nothing was doubted much lately
};

/// What has to be done now, once.
enum class SupervisorAction {
  kNothing,
  kBeginRelocalising,     ///< from the last scan in good order
  kResumeWithoutClosing,  ///< the CEKF goes on from there
  kEndWaiting,            ///< the CEKF goes on from where it waits, without closing
};

struct SupervisorDecision {
  FilterMode mode = FilterMode::kInitialising;
  SupervisorState state;  ///< for the next decision; its mode is `mode`
  SupervisorAction action = SupervisorAction::kNothing;
  double from_s = 0.0;            ///< T0 of the action: stamp of the last scan in good order
  bool silent = false;            ///< the filter in charge gives no poses
  bool without_odometry = false;  ///< map -> odom cannot follow it
  std::string reason;
  std::vector<EvidenceFigure> figures;
};

/// Who is in charge next, given who is now. Pure: the same arguments, the same decision. A CEKF
/// that is suspicious for long, or is lost by the LossTest, hands over to the relocaliser; the
/// relocaliser hands the place that it finds back to the CEKF by itself, and says what came of it.
/// If it finds none, or the CEKF refuses, the vehicle is LOST until the next attempt; after the
/// last attempt, or if the relocaliser falls silent, the CEKF goes on without closing the loop.
SupervisorDecision computeDecision(const SupervisorState& state, const SupervisorEvidence& evidence,
                                   const SupervisorConfig& config);

/// Whether the mode was switched: that a run begins in its first mode is no switch.
bool isModeSwitch(FilterMode before, FilterMode after);

}  // namespace hymm::core
