#include "supervisor/supervisor_decision.h"

#include <gmock/gmock.h>

namespace hymm::core {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;

TEST(SupervisorDecision, InitialisesUntilTheFilterGivesAPose) {
  const SupervisorDecision decision = computeDecision(FilterMode::kInitialising, {}, {});
  EXPECT_EQ(decision.mode, FilterMode::kInitialising);
  EXPECT_THAT(decision.reason, HasSubstr("No filter has given a pose"));
}

TEST(SupervisorDecision, FirstPosePutsTheCekfInCharge) {
  SupervisorEvidence evidence;
  evidence.pose_age_s = 0.0;
  const SupervisorDecision decision = computeDecision(FilterMode::kInitialising, evidence, {});
  EXPECT_EQ(decision.mode, FilterMode::kCekf);
  EXPECT_FALSE(decision.silent);
}

TEST(SupervisorDecision, SaysThatTheFilterIsSilentAndKeepsItInCharge) {
  SupervisorEvidence evidence;
  evidence.pose_age_s = 2.1;
  const SupervisorDecision decision = computeDecision(FilterMode::kCekf, evidence, {});
  EXPECT_EQ(decision.mode, FilterMode::kCekf);
  EXPECT_TRUE(decision.silent);
  EXPECT_THAT(decision.reason, HasSubstr("no pose"));
}

TEST(SupervisorDecision, NamesWhatTfLacks) {
  SupervisorEvidence evidence;
  evidence.pose_age_s = 0.1;
  evidence.odometry_known = false;
  evidence.odometry_problem = "no 'odom' -> 'base_link'";
  const SupervisorDecision decision = computeDecision(FilterMode::kCekf, evidence, {});
  EXPECT_TRUE(decision.without_odometry);
  EXPECT_THAT(decision.reason, HasSubstr("no 'odom' -> 'base_link'"));
}

TEST(SupervisorDecision, TakesTheFiguresOfTheScanAsEvidence) {
  FilterHealth health;
  health.nis = 12.0;
  health.dof = 8;
  health.ambiguity = 0.1;
  health.unexplained = 0.2;
  health.missed = 0.3;
  const SupervisorDecision decision =
      computeDecision(FilterMode::kInitialising, evidenceAtScan(health), {});
  EXPECT_EQ(decision.mode, FilterMode::kCekf);
  const auto figure = [](const char* name, double value) {
    return AllOf(Field(&EvidenceFigure::name, name), Field(&EvidenceFigure::value, value));
  };
  EXPECT_THAT(decision.figures, ElementsAre(figure("pose_age_s", 0.0), figure("nis_per_dof", 1.5),
                                            figure("ambiguity", 0.1), figure("unexplained", 0.2),
                                            figure("missed", 0.3)));
}

TEST(SupervisorDecision, BeginningIsNoSwitch) {
  EXPECT_FALSE(isModeSwitch(FilterMode::kInitialising, FilterMode::kCekf));
  EXPECT_FALSE(isModeSwitch(FilterMode::kCekf, FilterMode::kCekf));
  EXPECT_TRUE(isModeSwitch(FilterMode::kCekf, FilterMode::kRelocalising));
}

}  // namespace
}  // namespace hymm::core
