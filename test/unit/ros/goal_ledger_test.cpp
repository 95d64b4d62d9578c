#include "ros/goal_ledger.h"

#include <gtest/gtest.h>

namespace hymm {
namespace {

using Status = GoalLedger::Status;

const ros::Time kNow(100.0);

actionlib_msgs::GoalID makeId(const std::string& id, double stamp_s = 100.0) {
  actionlib_msgs::GoalID made;
  made.id = id;
  made.stamp = ros::Time(stamp_s);
  return made;
}

class TheGoalLedger : public testing::Test {
 protected:
  static void SetUpTestSuite() { ros::Time::init(); }  // for ids made up

  GoalLedger::Taken take(const std::string& id, double stamp_s = 100.0) {
    return ledger_.take(makeId(id, stamp_s), kNow, 0.0);
  }

  std::vector<Status> cancel(const std::string& id, double stamp_s = 0.0) {
    return ledger_.cancel(makeId(id, stamp_s), kNow, 0.0);
  }

  int stateOf(const std::string& id) {
    for (const Status& status : ledger_.statuses(0.0)) {
      if (status.goal_id.id == id) return status.status;
    }
    return Status::LOST;
  }

  GoalLedger ledger_;
};

TEST_F(TheGoalLedger, FollowsAGoalToItsEnd) {
  EXPECT_TRUE(take("a").waits);
  EXPECT_EQ(stateOf("a"), Status::PENDING);
  ledger_.begin("");
  EXPECT_EQ(stateOf("a"), Status::ACTIVE);
  EXPECT_FALSE(ledger_.hasWaiting());
  EXPECT_EQ(ledger_.end(Status::SUCCEEDED, "done", 0.0).goal_id.id, "a");
  EXPECT_EQ(stateOf("a"), Status::SUCCEEDED);
  EXPECT_FALSE(ledger_.current());
}

TEST_F(TheGoalLedger, TakesGoalsWhileASimulatedClockStandsAtZero) {
  const ros::Time zero;
  EXPECT_TRUE(ledger_.take(makeId("a", 0.0), zero, 0.0).waits);
  // Nothing older is known of than what comes at 0: only what waits is cancelled.
  EXPECT_EQ(ledger_.cancel(makeId("", 0.0), zero, 0.0).size(), 1u);
  EXPECT_TRUE(ledger_.take(makeId("b", 0.0), zero, 0.0).waits);
}

TEST_F(TheGoalLedger, LetsTheNewestReplaceTheOthersWhateverTheirStamps) {
  take("worked on", 4e9);
  ledger_.begin("");
  take("waits", 3e9);
  const GoalLedger::Taken taken = take("newest", 1.0);
  EXPECT_TRUE(taken.waits);
  ASSERT_EQ(taken.ended.size(), 1u);
  EXPECT_EQ(taken.ended[0].goal_id.id, "waits");
  EXPECT_EQ(taken.ended[0].status, Status::RECALLED);
  EXPECT_TRUE(ledger_.isAskedToEnd());
  EXPECT_EQ(stateOf("newest"), Status::PENDING);
}

TEST_F(TheGoalLedger, RecallsAGoalWhoseCancelCameFirst) {
  EXPECT_TRUE(cancel("a", 1.0).empty());
  const GoalLedger::Taken taken = take("a", 1.0);
  EXPECT_FALSE(taken.waits);
  ASSERT_EQ(taken.ended.size(), 1u);
  EXPECT_EQ(taken.ended[0].status, Status::RECALLED);
}

TEST_F(TheGoalLedger, TakesAnIdOnce) {
  take("a");
  EXPECT_FALSE(take("a").waits);
  ledger_.begin("");
  EXPECT_FALSE(take("a").waits);
  EXPECT_FALSE(ledger_.isAskedToEnd());
  ledger_.end(Status::SUCCEEDED, "", 0.0);
  EXPECT_FALSE(take("a").waits);
  EXPECT_EQ(ledger_.statuses(0.0).size(), 1u);
}

TEST_F(TheGoalLedger, MakesUpIdsForGoalsWithout) {
  EXPECT_TRUE(take("").waits);
  ledger_.begin("");
  EXPECT_TRUE(take("").waits);
  const std::vector<Status> statuses = ledger_.statuses(0.0);
  ASSERT_EQ(statuses.size(), 2u);
  EXPECT_FALSE(statuses[0].goal_id.id.empty());
  EXPECT_NE(statuses[0].goal_id.id, statuses[1].goal_id.id);
}

TEST_F(TheGoalLedger, CancelsById) {
  take("a");
  ledger_.begin("");
  take("b");
  EXPECT_EQ(cancel("b").size(), 1u);
  EXPECT_EQ(stateOf("b"), Status::RECALLED);
  cancel("a");
  EXPECT_EQ(stateOf("a"), Status::PREEMPTING);
}

TEST_F(TheGoalLedger, CancelsAllWithoutIdAndStamp) {
  take("a");
  ledger_.begin("");
  take("b");
  EXPECT_EQ(cancel("").size(), 1u);
  EXPECT_TRUE(ledger_.isAskedToEnd());
  EXPECT_TRUE(take("c").waits) << "it came later";
}

TEST_F(TheGoalLedger, CancelsWhatIsStampedUpToACancelAlsoIfItComesLater) {
  take("late", 90.0);
  take("early", 50.0);
  ledger_.begin("");
  cancel("", 60.0);
  EXPECT_TRUE(ledger_.isAskedToEnd());
  EXPECT_FALSE(take("on its way", 55.0).waits);
  EXPECT_TRUE(take("later", 61.0).waits);
}

TEST_F(TheGoalLedger, IsNotShutByACancelFromTheFuture) {
  cancel("", 4e9);
  EXPECT_FALSE(take("a", 99.0).waits);
  EXPECT_TRUE(take("b", 100.5).waits);
}

TEST_F(TheGoalLedger, ForgetsCancelsWhenTheClockRunsBack) {
  cancel("", 90.0);
  EXPECT_TRUE(ledger_.take(makeId("a", 10.0), ros::Time(10.0), 0.0).waits);
}

TEST_F(TheGoalLedger, TellsOfEndedGoalsForAWhileAndKeepsFew) {
  for (int i = 0; i < 1000; ++i) {
    cancel(std::to_string(i));
    take(std::to_string(i));
  }
  EXPECT_LE(ledger_.statuses(4.0).size(), 100u);
  EXPECT_FALSE(ledger_.statuses(4.0).empty());
  EXPECT_TRUE(ledger_.statuses(6.0).empty());
}

}  // namespace
}  // namespace hymm
