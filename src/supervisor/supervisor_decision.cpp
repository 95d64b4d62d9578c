#include "supervisor/supervisor_decision.h"

#include <algorithm>
#include <cmath>

#include "common/number_text.h"

namespace hymm::core {
namespace {

// Doubt that lasts is that of several scans, however long the time between them.
constexpr int kFewestSuspicious = 3;

// Stamps of a sensor's scans are not spaced to the bit.
constexpr double kSameTime_s = 1e-3;

/// A change of mode, or none.
struct Transition {
  FilterMode mode;
  SupervisorAction action = SupervisorAction::kNothing;
  std::string why;  ///< a sentence
};

Transition stay(FilterMode mode, const std::string& why = {}) {
  return {mode, SupervisorAction::kNothing, why};
}

Transition attempt(const std::string& why) {
  return {FilterMode::kRelocalising, SupervisorAction::kBeginRelocalising, why};
}

Transition goOnWithoutClosing(const std::string& why) {
  return {FilterMode::kCekf, SupervisorAction::kResumeWithoutClosing,
          why + " The CEKF goes on from where it was in good order, without closing the loop."};
}

/// Of a search that this supervisor knows nothing of: another one ordered it, and is gone.
Transition endWaiting() {
  return {FilterMode::kCekf, SupervisorAction::kEndWaiting,
          "The CEKF is in charge, but waits for a search that nobody is on. It goes on from where "
          "it waits, without closing the loop."};
}

bool hears(const std::optional<RelocaliserEvidence>& relocaliser, const SupervisorConfig& config) {
  return relocaliser && relocaliser->age_s <= config.pose_timeout_s;
}

/// "WHAT: why.", whether or not the reason ends as a sentence; "WHAT." if there is none.
std::string because(const std::string& what, std::string why) {
  while (!why.empty() && why.back() == '.') why.pop_back();
  return what + (why.empty() ? "" : ": " + why) + ".";
}

/// How long suspicion has to last.
double neededSuspicion_s(const ScanEvidence& scan, const SupervisorConfig& config) {
  return isArmed(scan, config.suspicion) ? config.switching.armed_suspicious_s
                                         : config.switching.suspicious_s;
}

std::string rounded(double seconds) { return numberText(std::round(10.0 * seconds) / 10.0); }

/// Why the CEKF is not believed any more, as a sentence; empty if it is.
std::string findDoubt(const SupervisorState& state, const SupervisorEvidence& evidence,
                      const SupervisorConfig& config) {
  if (state.loss.alarms(config.loss)) {
    return "Over " + rounded(evidence.time_s - state.good_order_s) +
           " s, landmarks that nothing hides were not seen, as a filter in good order would have "
           "it less than once in " +
           numberText(config.loss.false_alarm_interval_h) + " h.";
  }
  const std::string suspicion = findSuspicion(evidence.scan, config.suspicion);
  const bool lasts = state.suspicious_scans >= kFewestSuspicious &&
                     state.suspicious_s > neededSuspicion_s(evidence.scan, config) - kSameTime_s;
  if (suspicion.empty() || !lasts) return {};
  return "For " + std::to_string(state.suspicious_scans) + " scans in a row, over " +
         rounded(state.suspicious_s) + " s, " + suspicion + ".";
}

Transition fromCekf(const SupervisorState& state, const SupervisorEvidence& evidence,
                    const SupervisorConfig& config) {
  const bool waits_long = state.waits_from_s && evidence.time_s - *state.waits_from_s >
                                                    config.switching.retry_interval_s + kSameTime_s;
  if (waits_long) return endWaiting();
  const std::string doubt = findDoubt(state, evidence, config);
  if (doubt.empty()) return stay(FilterMode::kCekf);
  const std::string told = "The CEKF is in charge, though suspicious. " + doubt;
  if (!hears(evidence.relocaliser, config)) {
    return stay(FilterMode::kCekf, told + " No relocaliser runs that could find the place.");
  }
  if (!config.switching.automatic) {
    return stay(FilterMode::kCekf,
                told + " The relocaliser takes over by order only (switching/automatic).");
  }
  if (evidence.of_detections && !config.switching.automatic_by_detections) {
    return stay(FilterMode::kCekf,
                told +
                    " Detections do not tell what was hidden: the relocaliser takes over by order "
                    "only (switching/automatic_by_detections).");
  }
  if (evidence.time_s < state.not_before_s) {
    return stay(FilterMode::kCekf,
                told + " The relocaliser was asked lately; it is asked again soon.");
  }
  return attempt(doubt + " The relocaliser looks for the place.");
}

Transition fromRelocalising(const SupervisorState& state, const SupervisorEvidence& evidence,
                            const SupervisorConfig& config) {
  using State = RelocaliserEvidence::State;
  const double lasting_s = evidence.time_s - state.since_s;
  const std::optional<RelocaliserEvidence>& relocaliser = evidence.relocaliser;
  if (relocaliser && relocaliser->state == State::kAccepted) {
    return stay(
        FilterMode::kCekf,
        because("The relocaliser found the place, and the CEKF took it over", relocaliser->reason));
  }
  if (!hears(relocaliser, config)) {
    if (lasting_s <= config.pose_timeout_s) {
      return stay(FilterMode::kRelocalising, "The relocaliser is in charge; it was just asked.");
    }
    return goOnWithoutClosing("The relocaliser fell silent while it was in charge.");
  }
  if (relocaliser->state == State::kRefused) {
    return stay(FilterMode::kLost, because("The CEKF refused the place that the relocaliser found",
                                           relocaliser->reason));
  }
  if (relocaliser->state == State::kFailed) {
    return stay(FilterMode::kLost,
                because("The relocaliser cannot look for the place", relocaliser->reason));
  }
  if (lasting_s > config.switching.relocalise_timeout_s) {
    return stay(FilterMode::kLost,
                because("The relocaliser found no place in time", relocaliser->reason));
  }
  return stay(FilterMode::kRelocalising,
              because("The relocaliser is in charge", relocaliser->reason));
}

Transition fromLost(const SupervisorState& state, const SupervisorEvidence& evidence,
                    const SupervisorConfig& config) {
  if (!hears(evidence.relocaliser, config)) {
    return goOnWithoutClosing("The vehicle is lost, and no relocaliser runs.");
  }
  if (state.attempts >= config.switching.max_attempts) {
    return goOnWithoutClosing("The relocaliser found no place in " +
                              std::to_string(state.attempts) + " attempts.");
  }
  if (evidence.time_s < state.not_before_s) {
    return stay(FilterMode::kLost, "The vehicle is lost; the relocaliser tries again soon.");
  }
  return attempt("The vehicle is lost; the relocaliser tries again.");
}

Transition computeTransition(const SupervisorState& state, const SupervisorEvidence& evidence,
                             const SupervisorConfig& config) {
  if (state.mode == FilterMode::kInitialising) {
    return stay(evidence.pose_age_s ? FilterMode::kCekf : FilterMode::kInitialising);
  }
  if (evidence.requested == FilterMode::kCekf && state.mode != FilterMode::kCekf) {
    return goOnWithoutClosing("An operator asked for the CEKF.");
  }
  if (evidence.requested == FilterMode::kRelocalising && hears(evidence.relocaliser, config)) {
    return attempt("An operator asked for the relocaliser.");
  }
  switch (state.mode) {
    case FilterMode::kCekf:
      return fromCekf(state, evidence, config);
    case FilterMode::kRelocalising:
      return fromRelocalising(state, evidence, config);
    case FilterMode::kLost:
      return fromLost(state, evidence, config);
    case FilterMode::kInitialising:
      break;
  }
  return stay(state.mode);
}

/// The state with the scan counted.
SupervisorState counted(const SupervisorState& state, const SupervisorEvidence& evidence,
                        const SupervisorConfig& config) {
  SupervisorState result = state;
  if (state.mode != FilterMode::kCekf) {
    result.suspicious_scans = 0;
    result.suspicious_s = 0.0;
    result.last_scan_s.reset();
    result.loss = {};
    result.doubted_from_s.reset();
    result.waits_from_s.reset();
    return result;
  }
  if (!evidence.new_scan) return result;
  result.waits_from_s =
      evidence.waits ? std::optional(state.waits_from_s.value_or(evidence.time_s)) : std::nullopt;
  const double since_s = evidence.time_s - state.last_scan_s.value_or(state.good_order_s);
  const bool suspicious = !findSuspicion(evidence.scan, config.suspicion).empty();
  // Nothing is known of a gap in the scans.
  const double most_s = neededSuspicion_s(evidence.scan, config) / kFewestSuspicious;
  result.suspicious_scans = suspicious ? state.suspicious_scans + 1 : 0;
  result.suspicious_s = suspicious ? state.suspicious_s + std::clamp(since_s, 0.0, most_s) : 0.0;
  result.last_scan_s = evidence.time_s;
  result.loss = state.loss.after(evidence.time_s, evidence.scan, config.switching.longest_doubt_s,
                                 config.loss);
  if (result.loss.doubtsMuch()) result.doubted_from_s = result.loss.goodOrder_s();
  const bool in_good_order = !suspicious && !result.loss.doubts();
  const bool too_long_ago = evidence.time_s - state.good_order_s > config.switching.longest_doubt_s;
  if (in_good_order || too_long_ago) result.good_order_s = evidence.time_s;
  return result;
}

/// Where the search begins: what was doubted much a while ago, and then explained again, may have
/// been mapped anew in the wrong place.
double searchFrom_s(const SupervisorState& state, double time_s, const SwitchingConfig& config) {
  const double doubted_s = state.doubted_from_s.value_or(state.good_order_s);
  const bool is_kept = time_s - doubted_s <= config.longest_doubt_s;
  return is_kept ? std::min(state.good_order_s, doubted_s) : state.good_order_s;
}

SupervisorState follow(SupervisorState state, const Transition& transition, double time_s,
                       const SwitchingConfig& config) {
  const bool begins = transition.action == SupervisorAction::kBeginRelocalising;
  if (transition.action == SupervisorAction::kEndWaiting) state.waits_from_s.reset();
  if (transition.mode == state.mode && !begins) return state;
  if (begins) ++state.attempts;
  if (transition.mode == FilterMode::kLost) state.not_before_s = time_s + config.retry_interval_s;
  if (transition.mode == FilterMode::kCekf) {
    state.attempts = 0;
    state.not_before_s = time_s + (state.mode == FilterMode::kInitialising ? 0.0 : config.rest_s);
    state.good_order_s = time_s;
  }
  state.mode = transition.mode;
  state.since_s = time_s;
  state.suspicious_scans = 0;
  state.suspicious_s = 0.0;
  return state;
}

std::string computeReason(const SupervisorDecision& decision, const SupervisorEvidence& evidence) {
  if (decision.mode == FilterMode::kInitialising) {
    return "No filter has given a pose yet. The first comes with the first scan: do 'scan' (or "
           "'detections') and the motion input arrive at cekf_slam?";
  }
  if (decision.mode != FilterMode::kCekf) return {};
  if (decision.silent) {
    return "The CEKF is in charge, but has given no pose for a while: its inputs have stopped, or "
           "it is paused. See /diagnostics of cekf_slam.";
  }
  if (decision.without_odometry) {
    return "The CEKF is in charge, but map -> odom cannot follow it: " + evidence.odometry_problem;
  }
  return "The CEKF is in charge.";
}

std::vector<EvidenceFigure> figuresOf(const SupervisorState& state,
                                      const SupervisorEvidence& evidence,
                                      const SupervisorConfig& config) {
  if (!evidence.pose_age_s) return {};
  const ScanEvidence& scan = evidence.scan;
  const SuspicionConfig& limits = config.suspicion;
  const double nis_per_dof = scan.dof > 0 ? scan.nis / scan.dof : 0.0;
  const auto nis_limit =
      scan.dof > 0 ? std::optional<double>(nisLimit(scan.dof, limits)) : std::nullopt;
  return {{"pose_age_s", *evidence.pose_age_s, config.pose_timeout_s},
          {"nis_per_dof", nis_per_dof, nis_limit},
          {"ambiguity", scan.ambiguity, limits.ambiguity},
          {"unexplained", scan.unexplained, limits.unexplained},
          {"missed", scan.missed, std::nullopt},
          {"disagreement", scan.disagreement, limits.disagreement},
          {"unseen", scan.unseen, limits.unseen},
          {"old_landmarks_expected", static_cast<double>(scan.old_landmarks_expected),
           static_cast<double>(limits.old_landmarks)},
          {"position_deviation_m", scan.position_deviation_m, limits.armed_deviation_m},
          {"heading_deviation_rad", scan.heading_deviation_rad, limits.armed_deviation_rad},
          {"loss", state.loss.logRatio(), LossTest::limit(config.loss)}};
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
  schema.group("suspicion", suspicion);
  schema.group("loss", loss);
  schema.group("old_landmarks", old_landmarks);
  schema.group("switching", switching);
}

void SwitchingConfig::describe(ConfigSchema& schema) {
  schema.flag(
      "automatic", automatic,
      "the relocaliser takes over when the CEKF is suspicious; else only by order (set_mode, "
      "global_localization, initialpose), and suspicion is only told");
  schema.flag(
      "automatic_by_detections", automatic_by_detections,
      "likewise where the CEKF takes `detections`, which do not tell what was hidden, nor how far "
      "and how well their detector sees; where they tell identities, no association is in doubt");
  schema.number(
      "suspicious_s", suspicious_s, Range::positive(),
      "by stamps since the last scan that was not suspicious, three scans at least, after "
      "which the relocaliser takes over");
  schema.number("armed_suspicious_s", armed_suspicious_s, Range::positive(),
                "the same while the deviation is large");
  schema.number("relocalise_timeout_s", relocalise_timeout_s, Range::positive(),
                "longest attempt to relocalise");
  schema.number("retry_interval_s", retry_interval_s, Range::notNegative(),
                "time between two attempts");
  schema.integer("max_attempts", max_attempts, Range::between(1, 1000),
                 "attempts after which the CEKF goes on without closing the loop");
  schema.number("rest_s", rest_s, Range::notNegative(),
                "time after the CEKF took over again in which the relocaliser is not asked");
  schema.number("longest_doubt_s", longest_doubt_s, Range::between(1.0, 600.0),
                "the scan that a search begins from is no longer ago, and doubt that has come to "
                "nothing by then is dropped; cekf_slam/local_states_s has to be longer");
}

SupervisorEvidence evidenceAtScan(const FilterHealth& health) {
  SupervisorEvidence evidence;
  evidence.pose_age_s = 0.0;
  evidence.time_s = health.time_s;
  evidence.new_scan = true;
  evidence.scan = {health.nis,
                   health.dof,
                   health.ambiguity,
                   health.unexplained,
                   health.missed,
                   health.confirmed_expected,
                   health.confirmed_missed,
                   0.0,
                   0.0,
                   0,
                   health.position_deviation_m,
                   health.heading_deviation_rad};
  return evidence;
}

SupervisorDecision computeDecision(const SupervisorState& state, const SupervisorEvidence& evidence,
                                   const SupervisorConfig& config) {
  SupervisorState now = counted(state, evidence, config);
  const Transition transition = computeTransition(now, evidence, config);
  const bool leaves_cekf = now.mode == FilterMode::kCekf && transition.mode != now.mode;
  if (leaves_cekf) now.good_order_s = searchFrom_s(now, evidence.time_s, config.switching);
  SupervisorDecision decision;
  decision.state = follow(now, transition, evidence.time_s, config.switching);
  decision.mode = transition.mode;
  decision.action = transition.action;
  decision.from_s = now.good_order_s;
  decision.silent = evidence.pose_age_s && *evidence.pose_age_s > config.pose_timeout_s;
  decision.without_odometry = evidence.pose_age_s && !evidence.odometry_known;
  decision.reason = transition.why.empty() ? computeReason(decision, evidence) : transition.why;
  decision.figures = figuresOf(now, evidence, config);
  return decision;
}

bool isModeSwitch(FilterMode before, FilterMode after) {
  return after != before && before != FilterMode::kInitialising;
}

}  // namespace hymm::core
