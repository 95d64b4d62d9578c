#include "supervisor/supervisor_decision.h"

#include <gmock/gmock.h>

namespace hymm::core {
namespace {

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

}  // namespace
}  // namespace hymm::core
