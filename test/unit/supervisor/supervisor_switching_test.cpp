#include <gmock/gmock.h>

#include "scan_evidence.h"

namespace hymm::core {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

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

TEST(SupervisorDecision, SwitchesOnlyAfterSuspicionHasLasted) {
  const SupervisorConfig config;
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
  const SupervisorConfig config;
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
  const SupervisorConfig config;
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
  const SupervisorConfig config;
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
    return afterScans(stateIn(FilterMode::kCekf), evidence, scans, {}, 10.0).mode;
  };
  EXPECT_EQ(after(2), FilterMode::kCekf);
  EXPECT_EQ(after(4), FilterMode::kRelocalising);
}

TEST(SupervisorDecision, OneGoodScanEndsTheDoubt) {
  const SupervisorConfig config;
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
    decision = computeDecision(decision.state, evidence, {});
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
  go_on(withRelocaliser(ambiguous()), scansOver(SupervisorConfig().switching.suspicious_s));
  ASSERT_EQ(decision.action, SupervisorAction::kBeginRelocalising);
  EXPECT_DOUBLE_EQ(decision.from_s, doubted_from_s);
}

/// The filter keeps no way back to what was long ago.
TEST(SupervisorDecision, BeginsFromNoScanThatIsTooLongAgo) {
  SupervisorConfig config;
  config.switching.automatic = false;
  SupervisorDecision decision = afterScans(stateIn(FilterMode::kCekf), lost(1), 500, config);
  EXPECT_GE(decision.state.good_order_s,
            *decision.state.last_scan_s - config.switching.longest_doubt_s);
}

TEST(SupervisorDecision, BeginsFromTheLastScanInGoodOrder) {
  const SupervisorConfig config;
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

}  // namespace
}  // namespace hymm::core
