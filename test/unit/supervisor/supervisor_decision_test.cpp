#include "supervisor/supervisor_decision.h"

#include <gmock/gmock.h>

#include "scan_evidence.h"
#include "support/shipped_config.h"

namespace hymm::core {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::EndsWith;
using ::testing::Field;
using ::testing::HasSubstr;

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

TEST(SupervisorDecision, IsLostWhenTheRelocaliserFindsNothingInTime) {
  const SupervisorConfig config;
  SupervisorState state = stateIn(FilterMode::kRelocalising, 1);
  state.since_s = kNow_s - config.switching.relocalise_timeout_s - 0.1;
  const SupervisorDecision decision = computeDecision(state, withRelocaliser(healthy()), config);
  EXPECT_EQ(decision.mode, FilterMode::kLost);
  EXPECT_THAT(decision.reason, HasSubstr("more than one mode"));
}

TEST(SupervisorDecision, TriesAgainAfterAWhileAndNotForEver) {
  const SupervisorConfig config;
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
  const SupervisorConfig config;
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
  const SupervisorConfig config;
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
  const SupervisorConfig config;
  const int scans = scansOver(config.switching.retry_interval_s) + 1;
  const SupervisorDecision before = afterScans(stateIn(FilterMode::kCekf), waiting(), scans);
  EXPECT_EQ(before.action, SupervisorAction::kNothing);
  const SupervisorDecision after = afterScans(stateIn(FilterMode::kCekf), waiting(), scans + 1);
  EXPECT_EQ(after.action, SupervisorAction::kEndWaiting);
  EXPECT_EQ(after.mode, FilterMode::kCekf);
  EXPECT_THAT(after.reason, HasSubstr("nobody"));
}

TEST(SupervisorDecision, AsksOnceThatTheWaitingEnds) {
  const int scans = scansOver(SupervisorConfig().switching.retry_interval_s) + 2;
  const SupervisorDecision ended = afterScans(stateIn(FilterMode::kCekf), waiting(), scans);
  SupervisorEvidence next = waiting();
  next.time_s += scans * kPeriod_s;
  EXPECT_EQ(computeDecision(ended.state, next, {}).action, SupervisorAction::kNothing);
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

}  // namespace
}  // namespace hymm::core
