#include "supervisor/supervisor_decision.h"

#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "support/shipped_config.h"

namespace hymm::core {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::EndsWith;
using ::testing::Field;
using ::testing::HasSubstr;

constexpr double kNow_s = 100.0;
constexpr double kPeriod_s = 0.2;  // of scans

/// Suspicious scans that last so long, one after the other.
int scansOver(double duration_s, double period_s = kPeriod_s) {
  return static_cast<int>(std::lround(duration_s / period_s));
}

SupervisorState stateIn(FilterMode mode, int attempts = 0) {
  SupervisorState state;
  state.mode = mode;
  state.since_s = kNow_s - 1.0;
  state.attempts = attempts;
  state.good_order_s = kNow_s - kPeriod_s;
  return state;
}

/// A scan that the CEKF explains well.
SupervisorEvidence healthy() {
  SupervisorEvidence evidence;
  evidence.time_s = kNow_s;
  evidence.pose_age_s = 0.0;
  evidence.new_scan = true;
  evidence.scan.nis = 10.0;
  evidence.scan.dof = 10;
  return evidence;
}

SupervisorConfig automatic() { return {}; }

SupervisorEvidence ambiguous() {
  SupervisorEvidence evidence = healthy();
  evidence.scan.ambiguity = 0.9;
  evidence.scan.old_landmarks_expected = 3;
  return evidence;
}

using Search = RelocaliserEvidence::State;

SupervisorEvidence withRelocaliser(SupervisorEvidence evidence, Search state = Search::kSearching) {
  evidence.relocaliser = RelocaliserEvidence{0.1, state, "there is more than one mode"};
  return evidence;
}

/// The state after `scans` scans of the same kind.
SupervisorDecision afterScans(SupervisorState state, SupervisorEvidence evidence, int scans,
                              const SupervisorConfig& config = automatic(),
                              double period_s = kPeriod_s) {
  SupervisorDecision decision;
  decision.state = state;
  for (int i = 0; i < scans; ++i) {
    decision = computeDecision(decision.state, evidence, config);
    evidence.time_s += period_s;
  }
  return decision;
}

TEST(SupervisorDecision, InitialisesUntilTheFilterGivesAPose) {
  const SupervisorDecision decision = computeDecision({}, {}, {});
  EXPECT_EQ(decision.mode, FilterMode::kInitialising);
  EXPECT_THAT(decision.reason, HasSubstr("No filter has given a pose"));
}

TEST(SupervisorDecision, FirstPosePutsTheCekfInCharge) {
  SupervisorEvidence evidence;
  evidence.pose_age_s = 0.0;
  const SupervisorDecision decision = computeDecision({}, evidence, {});
  EXPECT_EQ(decision.mode, FilterMode::kCekf);
  EXPECT_FALSE(decision.silent);
}

TEST(SupervisorDecision, SaysThatTheFilterIsSilentAndKeepsItInCharge) {
  SupervisorEvidence evidence;
  evidence.pose_age_s = 2.1;
  const SupervisorDecision decision = computeDecision(stateIn(FilterMode::kCekf), evidence, {});
  EXPECT_EQ(decision.mode, FilterMode::kCekf);
  EXPECT_TRUE(decision.silent);
  EXPECT_THAT(decision.reason, HasSubstr("no pose"));
}

TEST(SupervisorDecision, NamesWhatTfLacks) {
  SupervisorEvidence evidence;
  evidence.pose_age_s = 0.1;
  evidence.odometry_known = false;
  evidence.odometry_problem = "no 'odom' -> 'base_link'";
  const SupervisorDecision decision = computeDecision(stateIn(FilterMode::kCekf), evidence, {});
  EXPECT_TRUE(decision.without_odometry);
  EXPECT_THAT(decision.reason, HasSubstr("no 'odom' -> 'base_link'"));
}

TEST(SupervisorDecision, TakesTheFiguresOfTheScanAsEvidence) {
  FilterHealth health;
  health.time_s = 7.0;
  health.nis = 12.0;
  health.dof = 8;
  health.ambiguity = 0.1;
  health.unexplained = 0.2;
  health.missed = 0.3;
  health.position_deviation_m = 0.4;
  health.heading_deviation_rad = 0.05;
  const SupervisorEvidence evidence = evidenceAtScan(health);
  EXPECT_TRUE(evidence.new_scan);
  EXPECT_EQ(evidence.time_s, 7.0);
  const SupervisorDecision decision = computeDecision({}, evidence, {});
  EXPECT_EQ(decision.mode, FilterMode::kCekf);
  const auto figure = [](const char* name, double value) {
    return Contains(
        AllOf(Field(&EvidenceFigure::name, name), Field(&EvidenceFigure::value, value)));
  };
  EXPECT_THAT(decision.figures,
              AllOf(figure("pose_age_s", 0.0), figure("nis_per_dof", 1.5), figure("ambiguity", 0.1),
                    figure("unexplained", 0.2), figure("missed", 0.3),
                    figure("position_deviation_m", 0.4), figure("heading_deviation_rad", 0.05)));
}

TEST(SupervisorDecision, BeginningIsNoSwitch) {
  EXPECT_FALSE(isModeSwitch(FilterMode::kInitialising, FilterMode::kCekf));
  EXPECT_FALSE(isModeSwitch(FilterMode::kCekf, FilterMode::kCekf));
  EXPECT_TRUE(isModeSwitch(FilterMode::kCekf, FilterMode::kRelocalising));
}

TEST(Suspicion, FallsOnEachKindOfFailureAlone) {
  const SuspicionConfig config;
  EXPECT_EQ(findSuspicion(healthy().scan, config), "");
  ScanEvidence among_old = healthy().scan;
  among_old.old_landmarks_expected = 3;
  ScanEvidence scan = among_old;
  scan.ambiguity = 0.6;
  EXPECT_THAT(findSuspicion(scan, config), HasSubstr("ambiguous"));
  scan = healthy().scan;
  scan.nis = 60.0;
  EXPECT_THAT(findSuspicion(scan, config), HasSubstr("do not fit"));
  scan = among_old;
  scan.disagreement = 0.6;
  EXPECT_THAT(findSuspicion(scan, config), HasSubstr("grid"));
  scan = among_old;
  scan.unseen = 1.0;
  EXPECT_THAT(findSuspicion(scan, config), HasSubstr("old landmarks"));
}

TEST(Suspicion, DoesNotFallOnExploring) {
  ScanEvidence scan = healthy().scan;
  scan.unexplained = scan.ambiguity = scan.disagreement = scan.unseen = 1.0;
  scan.old_landmarks_expected = 2;
  EXPECT_EQ(findSuspicion(scan, {}), "");
  scan.ambiguity = scan.disagreement = scan.unseen = 0.0;
  scan.old_landmarks_expected = 3;
  EXPECT_THAT(findSuspicion(scan, {}), HasSubstr("old landmarks"));
}

TEST(SupervisorDecision, OnlyTellsOfSuspicionUnlessItMaySwitch) {
  SupervisorConfig config;
  config.switching.automatic = false;
  const SupervisorDecision decision =
      afterScans(stateIn(FilterMode::kCekf), withRelocaliser(ambiguous()), 50, config);
  EXPECT_EQ(decision.mode, FilterMode::kCekf);
  EXPECT_THAT(decision.reason, AllOf(HasSubstr("ambiguous"), HasSubstr("by order only")));
}

TEST(SupervisorDecision, OnlyTellsOfSuspicionByDetectionsUnlessItMaySwitch) {
  SupervisorEvidence evidence = withRelocaliser(ambiguous());
  evidence.of_detections = true;
  SupervisorConfig config;
  const SupervisorDecision told = afterScans(stateIn(FilterMode::kCekf), evidence, 50, config);
  EXPECT_EQ(told.mode, FilterMode::kCekf);
  EXPECT_THAT(told.reason, AllOf(HasSubstr("ambiguous"), HasSubstr("automatic_by_detections")));
  config.switching.automatic_by_detections = true;
  EXPECT_EQ(afterScans(stateIn(FilterMode::kCekf), evidence, 50, config).mode,
            FilterMode::kRelocalising);
}

TEST(Suspicion, NeverFallsOnALargeDeviationAlone) {
  ScanEvidence scan = healthy().scan;
  scan.position_deviation_m = 50.0;
  scan.heading_deviation_rad = 1.0;
  EXPECT_TRUE(isArmed(scan, {}));
  EXPECT_EQ(findSuspicion(scan, {}), "");
}

TEST(SupervisorDecision, SwitchesOnlyAfterSuspicionHasLasted) {
  const SupervisorConfig config = automatic();
  const SupervisorEvidence evidence = withRelocaliser(ambiguous());
  const int needed = scansOver(config.switching.suspicious_s);
  EXPECT_EQ(afterScans(stateIn(FilterMode::kCekf), evidence, needed - 1).mode, FilterMode::kCekf);
  const SupervisorDecision decision = afterScans(stateIn(FilterMode::kCekf), evidence, needed);
  EXPECT_EQ(decision.mode, FilterMode::kRelocalising);
  EXPECT_EQ(decision.action, SupervisorAction::kBeginRelocalising);
  EXPECT_EQ(decision.state.attempts, 1);
  EXPECT_THAT(decision.reason, HasSubstr("ambiguous"));
}

TEST(SupervisorDecision, SwitchesSoonerWhereTheDeviationIsLarge) {
  const SupervisorConfig config = automatic();
  SupervisorEvidence evidence = withRelocaliser(ambiguous());
  evidence.scan.position_deviation_m = 3.0;
  EXPECT_EQ(afterScans(stateIn(FilterMode::kCekf), evidence,
                       scansOver(config.switching.armed_suspicious_s))
                .mode,
            FilterMode::kRelocalising);
  SupervisorEvidence uncertain = withRelocaliser(healthy());
  uncertain.scan.position_deviation_m = 3.0;
  EXPECT_EQ(afterScans(stateIn(FilterMode::kCekf), uncertain, 1000).mode, FilterMode::kCekf);
}

TEST(SupervisorDecision, SwitchesAfterTheSameTimeWhateverTheSensorsRate) {
  const SupervisorConfig config = automatic();
  const SupervisorEvidence evidence = withRelocaliser(ambiguous());
  for (const double period_s : {0.05, 0.1, 0.2, 0.5}) {
    SupervisorState state = stateIn(FilterMode::kCekf);
    state.good_order_s = kNow_s - period_s;  // no scan was counted yet
    const int needed = scansOver(config.switching.suspicious_s, period_s);
    EXPECT_EQ(afterScans(state, evidence, needed - 1, config, period_s).mode, FilterMode::kCekf);
    EXPECT_EQ(afterScans(state, evidence, needed, config, period_s).mode,
              FilterMode::kRelocalising);
  }
}

/// What a gap hides may have been in good order.
TEST(SupervisorDecision, DoesNotSwitchAfterAGapInTheScans) {
  const SupervisorConfig config = automatic();
  SupervisorEvidence evidence = withRelocaliser(ambiguous());
  evidence.time_s = kNow_s + 60.0;
  const int needed = scansOver(config.switching.suspicious_s);
  EXPECT_EQ(afterScans(stateIn(FilterMode::kCekf), evidence, needed - 3).mode, FilterMode::kCekf);
  EXPECT_EQ(afterScans(stateIn(FilterMode::kCekf), evidence, needed).mode,
            FilterMode::kRelocalising);
}

TEST(SupervisorDecision, TakesThreeScansHoweverFarApart) {
  const SupervisorEvidence evidence = withRelocaliser(ambiguous());
  const auto after = [&](int scans) {
    return afterScans(stateIn(FilterMode::kCekf), evidence, scans, automatic(), 10.0).mode;
  };
  EXPECT_EQ(after(2), FilterMode::kCekf);
  EXPECT_EQ(after(4), FilterMode::kRelocalising);
}

/// All of `expected` landmarks in clear view are missed, and nothing is explained.
SupervisorEvidence lost(int expected) {
  SupervisorEvidence evidence = withRelocaliser(healthy());
  evidence.scan.nis = 0.0;
  evidence.scan.dof = 0;
  evidence.scan.unexplained = 1.0;
  evidence.scan.confirmed_expected = evidence.scan.confirmed_missed = expected;
  return evidence;
}

TEST(SupervisorDecision, SwitchesWhereConfirmedLandmarksAreMissedThoughNoneIsOld) {
  const SupervisorDecision decision = afterScans(stateIn(FilterMode::kCekf), lost(5), 9);
  EXPECT_EQ(decision.mode, FilterMode::kRelocalising);
  EXPECT_THAT(decision.reason, AllOf(HasSubstr("nothing hides"), HasSubstr("once in 1 h")));
}

TEST(SupervisorDecision, BeginsFromTheScanBeforeTheLandmarksWereMissed) {
  SupervisorDecision decision =
      afterScans(stateIn(FilterMode::kCekf), withRelocaliser(healthy()), 5);
  SupervisorEvidence evidence = lost(5);
  evidence.time_s = kNow_s + 5 * kPeriod_s;
  const SupervisorState before = decision.state;
  while (decision.mode == FilterMode::kCekf && evidence.time_s < kNow_s + 20.0) {
    decision = computeDecision(decision.state, evidence, automatic());
    evidence.time_s += kPeriod_s;
  }
  ASSERT_EQ(decision.action, SupervisorAction::kBeginRelocalising);
  EXPECT_DOUBLE_EQ(decision.from_s, before.good_order_s);
  EXPECT_DOUBLE_EQ(decision.from_s, kNow_s + 4 * kPeriod_s);
}

/// What it mapped after a doubt that passed may be in the wrong place.
TEST(SupervisorDecision, BeginsFromBeforeAMuchDoubtedScanThatWasExplainedAgain) {
  SupervisorDecision decision =
      afterScans(stateIn(FilterMode::kCekf), withRelocaliser(healthy()), 5);
  const double doubted_from_s = kNow_s + 4 * kPeriod_s;
  const auto go_on = [&](SupervisorEvidence evidence, int scans) {
    evidence.time_s = *decision.state.last_scan_s + kPeriod_s;
    decision = afterScans(decision.state, evidence, scans);
  };
  go_on(lost(5), 3);
  ASSERT_TRUE(decision.state.loss.doubtsMuch());
  SupervisorEvidence explained = withRelocaliser(healthy());
  explained.scan.confirmed_expected = 5;
  go_on(explained, 20);
  ASSERT_FALSE(decision.state.loss.doubts());
  go_on(withRelocaliser(ambiguous()), scansOver(automatic().switching.suspicious_s));
  ASSERT_EQ(decision.action, SupervisorAction::kBeginRelocalising);
  EXPECT_DOUBLE_EQ(decision.from_s, doubted_from_s);
}

/// The filter keeps no way back to what was long ago.
TEST(SupervisorDecision, BeginsFromNoScanThatIsTooLongAgo) {
  SupervisorConfig config = automatic();
  config.switching.automatic = false;
  SupervisorDecision decision = afterScans(stateIn(FilterMode::kCekf), lost(1), 500, config);
  EXPECT_GE(decision.state.good_order_s,
            *decision.state.last_scan_s - config.switching.longest_doubt_s);
}

TEST(SupervisorDecision, OneGoodScanEndsTheDoubt) {
  const SupervisorConfig config = automatic();
  const SupervisorDecision nearly =
      afterScans(stateIn(FilterMode::kCekf), withRelocaliser(ambiguous()),
                 scansOver(config.switching.suspicious_s) - 1);
  const SupervisorDecision after =
      computeDecision(nearly.state, withRelocaliser(healthy()), config);
  EXPECT_EQ(after.state.suspicious_scans, 0);
}

TEST(SupervisorDecision, CountsAScanOnceHoweverOftenItIsAsked) {
  SupervisorEvidence evidence = withRelocaliser(ambiguous());
  evidence.new_scan = false;
  EXPECT_EQ(afterScans(stateIn(FilterMode::kCekf), evidence, 1000).mode, FilterMode::kCekf);
}

TEST(SupervisorDecision, SaysThatNoRelocaliserRunsThatCouldHelp) {
  const SupervisorDecision decision = afterScans(stateIn(FilterMode::kCekf), ambiguous(), 50);
  EXPECT_EQ(decision.mode, FilterMode::kCekf);
  EXPECT_EQ(decision.action, SupervisorAction::kNothing);
  EXPECT_THAT(decision.reason, AllOf(HasSubstr("ambiguous"), HasSubstr("No relocaliser runs")));
}

TEST(SupervisorDecision, ReturnsWhenTheCekfHasTakenThePlace) {
  const SupervisorDecision decision = computeDecision(
      stateIn(FilterMode::kRelocalising, 2), withRelocaliser(healthy(), Search::kAccepted), {});
  EXPECT_EQ(decision.mode, FilterMode::kCekf);
  EXPECT_EQ(decision.action, SupervisorAction::kNothing);
  EXPECT_EQ(decision.state.attempts, 0);
}

TEST(SupervisorDecision, IsLostWhenTheCekfRefusesThePlace) {
  const SupervisorDecision decision = computeDecision(
      stateIn(FilterMode::kRelocalising, 1), withRelocaliser(healthy(), Search::kRefused), {});
  EXPECT_EQ(decision.mode, FilterMode::kLost);
  EXPECT_THAT(decision.reason, HasSubstr("refused"));
}

TEST(SupervisorDecision, IsLostAtOnceWhereTheRelocaliserCannotBegin) {
  SupervisorEvidence evidence = withRelocaliser(healthy(), Search::kFailed);
  evidence.relocaliser->reason = "The map has no landmarks.";
  const SupervisorDecision decision =
      computeDecision(stateIn(FilterMode::kRelocalising, 1), evidence, {});
  EXPECT_EQ(decision.mode, FilterMode::kLost);
  EXPECT_THAT(decision.reason, EndsWith("look for the place: The map has no landmarks."));
}

TEST(SupervisorDecision, BeginsFromTheLastScanInGoodOrder) {
  const SupervisorConfig config = automatic();
  SupervisorEvidence evidence = withRelocaliser(healthy());
  const SupervisorDecision good = computeDecision(stateIn(FilterMode::kCekf), evidence, config);
  evidence = withRelocaliser(ambiguous());
  evidence.time_s = kNow_s + 0.2;
  const SupervisorDecision begun =
      afterScans(good.state, evidence, scansOver(config.switching.suspicious_s));
  EXPECT_EQ(begun.action, SupervisorAction::kBeginRelocalising);
  EXPECT_EQ(begun.from_s, kNow_s);
  SupervisorEvidence silent = healthy();
  silent.time_s = kNow_s + 100.0;
  const SupervisorDecision back = computeDecision(begun.state, silent, config);
  EXPECT_EQ(back.action, SupervisorAction::kResumeWithoutClosing);
  EXPECT_EQ(back.from_s, kNow_s);
}

TEST(SupervisorDecision, IsLostWhenTheRelocaliserFindsNothingInTime) {
  const SupervisorConfig config = automatic();
  SupervisorState state = stateIn(FilterMode::kRelocalising, 1);
  state.since_s = kNow_s - config.switching.relocalise_timeout_s - 0.1;
  const SupervisorDecision decision = computeDecision(state, withRelocaliser(healthy()), config);
  EXPECT_EQ(decision.mode, FilterMode::kLost);
  EXPECT_THAT(decision.reason, HasSubstr("more than one mode"));
}

TEST(SupervisorDecision, TriesAgainAfterAWhileAndNotForEver) {
  const SupervisorConfig config = automatic();
  SupervisorState state = stateIn(FilterMode::kLost, 1);
  state.not_before_s = kNow_s + 1.0;
  EXPECT_EQ(computeDecision(state, withRelocaliser(healthy()), config).mode, FilterMode::kLost);
  state.not_before_s = kNow_s;
  const SupervisorDecision again = computeDecision(state, withRelocaliser(healthy()), config);
  EXPECT_EQ(again.action, SupervisorAction::kBeginRelocalising);
  EXPECT_EQ(again.state.attempts, 2);
  state.attempts = config.switching.max_attempts;
  const SupervisorDecision last = computeDecision(state, withRelocaliser(healthy()), config);
  EXPECT_EQ(last.mode, FilterMode::kCekf);
  EXPECT_EQ(last.action, SupervisorAction::kResumeWithoutClosing);
  EXPECT_THAT(last.reason, HasSubstr("without closing"));
}

TEST(SupervisorDecision, RestsAfterTheCekfTookOverAgain) {
  const SupervisorConfig config = automatic();
  SupervisorState state = stateIn(FilterMode::kLost, config.switching.max_attempts);
  const SupervisorDecision back = computeDecision(state, withRelocaliser(healthy()), config);
  SupervisorEvidence evidence = withRelocaliser(ambiguous());
  const SupervisorDecision resting = afterScans(back.state, evidence, 20, config);
  EXPECT_EQ(resting.mode, FilterMode::kCekf);
  EXPECT_THAT(resting.reason, HasSubstr("asked lately"));
  evidence.time_s = kNow_s + config.switching.rest_s;
  EXPECT_EQ(computeDecision(resting.state, evidence, config).mode, FilterMode::kRelocalising);
}

TEST(SupervisorDecision, FallsBackWhenTheRelocaliserDiesInCharge) {
  const SupervisorConfig config = automatic();
  SupervisorState state = stateIn(FilterMode::kRelocalising, 1);
  state.since_s = kNow_s - 10.0;
  SupervisorEvidence evidence = withRelocaliser(healthy());
  evidence.relocaliser->age_s = config.pose_timeout_s + 0.1;
  for (const bool gone : {false, true}) {
    if (gone) evidence.relocaliser.reset();
    const SupervisorDecision decision = computeDecision(state, evidence, config);
    EXPECT_EQ(decision.mode, FilterMode::kCekf);
    EXPECT_EQ(decision.action, SupervisorAction::kResumeWithoutClosing);
    EXPECT_THAT(decision.reason, HasSubstr("silent"));
  }
}

TEST(SupervisorDecision, FollowsAnOperator) {
  SupervisorEvidence evidence = withRelocaliser(healthy());
  evidence.requested = FilterMode::kRelocalising;
  for (const auto mode : {FilterMode::kCekf, FilterMode::kRelocalising, FilterMode::kLost}) {
    EXPECT_EQ(computeDecision(stateIn(mode), evidence, {}).action,
              SupervisorAction::kBeginRelocalising);
  }
  evidence.requested = FilterMode::kCekf;
  EXPECT_EQ(computeDecision(stateIn(FilterMode::kRelocalising), evidence, {}).action,
            SupervisorAction::kResumeWithoutClosing);
}

/// A filter in charge that waits though this supervisor has asked for no search.
SupervisorEvidence waiting() {
  SupervisorEvidence evidence = healthy();
  evidence.waits = true;
  return evidence;
}

TEST(SupervisorDecision, EndsTheWaitingForASearchThatNobodyIsOn) {
  const SupervisorConfig config = automatic();
  const int scans = scansOver(config.switching.retry_interval_s) + 1;
  const SupervisorDecision before = afterScans(stateIn(FilterMode::kCekf), waiting(), scans);
  EXPECT_EQ(before.action, SupervisorAction::kNothing);
  const SupervisorDecision after = afterScans(stateIn(FilterMode::kCekf), waiting(), scans + 1);
  EXPECT_EQ(after.action, SupervisorAction::kEndWaiting);
  EXPECT_EQ(after.mode, FilterMode::kCekf);
  EXPECT_THAT(after.reason, HasSubstr("nobody"));
}

TEST(SupervisorDecision, AsksOnceThatTheWaitingEnds) {
  const int scans = scansOver(automatic().switching.retry_interval_s) + 2;
  const SupervisorDecision ended = afterScans(stateIn(FilterMode::kCekf), waiting(), scans);
  SupervisorEvidence next = waiting();
  next.time_s += scans * kPeriod_s;
  EXPECT_EQ(computeDecision(ended.state, next, automatic()).action, SupervisorAction::kNothing);
}

TEST(SupervisorDecision, LetsTheFilterWaitForItsOwnSearch) {
  SupervisorState state = stateIn(FilterMode::kRelocalising);
  const SupervisorDecision decision =
      afterScans(state, withRelocaliser(waiting()), scansOver(20.0));
  EXPECT_EQ(decision.mode, FilterMode::kRelocalising);
  EXPECT_EQ(decision.action, SupervisorAction::kNothing);
}

TEST(SupervisorConfig, IsDocumentedByItsShippedFile) {
  test::expectDocumentedByShippedFile("supervisor", SupervisorConfig());
}

/// Every mode with every combination of what can be told.
class EveryDecision : public ::testing::Test {
 protected:
  struct Case {
    SupervisorState state;
    SupervisorEvidence evidence;
  };

  static std::vector<SupervisorState> states() {
    std::vector<SupervisorState> states;
    for (const auto mode : {FilterMode::kInitialising, FilterMode::kCekf, FilterMode::kRelocalising,
                            FilterMode::kLost}) {
      for (const int attempts : {0, 1, 3, 4}) {
        for (const double age_s : {0.0, 10.0, 1000.0}) {
          for (const int suspicious : {0, 2, 9}) {
            for (const double wait_s : {-1.0, 5.0}) {
              SupervisorState state = stateIn(mode, attempts);
              state.since_s = kNow_s - age_s;
              state.suspicious_scans = suspicious;
              state.suspicious_s = kPeriod_s * suspicious;
              state.not_before_s = kNow_s + wait_s;
              state.good_order_s = kNow_s - 2.0;
              state.waits_from_s = kNow_s - 2.0 * age_s;
              states.push_back(state);
            }
          }
        }
      }
    }
    return states;
  }

  static std::vector<SupervisorEvidence> evidences() {
    std::vector<SupervisorEvidence> evidences;
    for (const bool posed : {false, true}) {
      for (const bool doubtful : {false, true}) {
        for (const bool armed : {false, true}) {
          for (const bool silent : {false, true}) {
            for (const std::optional<Search> search :
                 {std::optional<Search>(), std::optional(Search::kSearching),
                  std::optional(Search::kAccepted), std::optional(Search::kRefused),
                  std::optional(Search::kFailed)}) {
              for (const int request : {0, 1, 2}) {
                SupervisorEvidence evidence = doubtful ? ambiguous() : healthy();
                if (!posed) evidence.pose_age_s.reset();
                if (armed) evidence.scan.position_deviation_m = 10.0;
                if (search) evidence = withRelocaliser(evidence, *search);
                if (search && silent) evidence.relocaliser->age_s = 100.0;
                if (request == 1) evidence.requested = FilterMode::kCekf;
                if (request == 2) evidence.requested = FilterMode::kRelocalising;
                evidences.push_back(evidence);
                evidence.waits = true;
                evidences.push_back(evidence);
              }
            }
          }
        }
      }
    }
    return evidences;
  }

  template <class Check>
  static void forEach(Check check) {
    const SupervisorConfig config = automatic();
    const auto all_evidences = evidences();
    for (const SupervisorState& state : states()) {
      for (const SupervisorEvidence& evidence : all_evidences) {
        check(state, evidence, computeDecision(state, evidence, config));
      }
    }
  }
};

TEST_F(EveryDecision, StatesItsReasonAndRemembersItsMode) {
  forEach([](const SupervisorState&, const SupervisorEvidence&, const SupervisorDecision& d) {
    EXPECT_FALSE(d.reason.empty());
    EXPECT_THAT(d.reason, EndsWith(d.mode == FilterMode::kInitialising ? "?" : "."));
    EXPECT_EQ(d.state.mode, d.mode);
  });
}

TEST_F(EveryDecision, ActsExactlyWhenItSwitchesAwayFromAFilterOrHandsBack) {
  forEach([](const SupervisorState& state, const SupervisorEvidence& evidence,
             const SupervisorDecision& d) {
    const bool switches = isModeSwitch(state.mode, d.mode);
    switch (d.action) {
      case SupervisorAction::kBeginRelocalising:
        EXPECT_EQ(d.mode, FilterMode::kRelocalising);
        EXPECT_TRUE(switches || evidence.requested == FilterMode::kRelocalising);
        EXPECT_EQ(d.state.attempts, state.attempts + 1);
        break;
      case SupervisorAction::kResumeWithoutClosing:
        EXPECT_TRUE(switches && d.mode == FilterMode::kCekf);
        break;
      case SupervisorAction::kEndWaiting:
        EXPECT_TRUE(evidence.waits && state.mode == FilterMode::kCekf && d.mode == state.mode);
        break;
      case SupervisorAction::kNothing:
        EXPECT_NE(switches, d.mode == state.mode || state.mode == FilterMode::kInitialising);
        EXPECT_FALSE(switches && d.mode == FilterMode::kRelocalising);
        break;
    }
  });
}

TEST_F(EveryDecision, NeverRelocalisesWithoutARelocaliser) {
  forEach([](const SupervisorState& state, const SupervisorEvidence& evidence,
             const SupervisorDecision& d) {
    const bool hears = evidence.relocaliser && evidence.relocaliser->age_s < 1.0;
    if (hears || state.mode == FilterMode::kRelocalising) return;
    EXPECT_NE(d.mode, FilterMode::kRelocalising);
  });
}

TEST_F(EveryDecision, NeverLeavesAHealthyCekfUnlessAsked) {
  forEach([](const SupervisorState& state, const SupervisorEvidence& evidence,
             const SupervisorDecision& d) {
    const bool asked = evidence.requested == FilterMode::kRelocalising;
    if (state.mode != FilterMode::kCekf || evidence.scan.ambiguity > 0.0 || asked) return;
    EXPECT_EQ(d.mode, FilterMode::kCekf);
  });
}

TEST_F(EveryDecision, ReturnsToTheCekfOnlyByItsConsentOrWithoutClosing) {
  forEach([](const SupervisorState& state, const SupervisorEvidence& evidence,
             const SupervisorDecision& d) {
    if (d.mode != FilterMode::kCekf || !isModeSwitch(state.mode, d.mode)) return;
    const bool accepted = evidence.relocaliser && evidence.relocaliser->state == Search::kAccepted;
    EXPECT_TRUE(accepted || d.action == SupervisorAction::kResumeWithoutClosing);
  });
}

}  // namespace
}  // namespace hymm::core
