#include "ros/odom_correction.h"

#include <gtest/gtest.h>

namespace hymm {
namespace {

/// A vehicle at 1 m/s along x, and tf that has heard of it up to some time.
class OdomCorrectionTest : public testing::Test {
 protected:
  static constexpr double kWait_s = 1.0;

  static double odometryAt_m(double time_s) { return time_s; }

  TransformAnswer lookUp(const ros::Time& stamp) const {
    if (stamp.toSec() > heard_up_to_s || stamp.toSec() < heard_from_s) {
      return {std::nullopt, "extrapolation"};
    }
    geometry_msgs::TransformStamped transform;
    transform.transform.translation.x = odometryAt_m(stamp.toSec());
    transform.transform.rotation.w = 1.0;
    return {transform, ""};
  }

  /// The map is `drift_m` beside the odometry.
  void setPose(double time_s, double drift_m) {
    correction.setPose(ros::Time(time_s), core::Pose2{odometryAt_m(time_s), drift_m, 0.0}, time_s);
  }
  void expectDrift(double drift_m, double pose_s) const {
    ASSERT_TRUE(correction.T_map_odom());
    EXPECT_NEAR(correction.T_map_odom()->x_m, 0.0, 1e-9);
    EXPECT_NEAR(correction.T_map_odom()->y_m, drift_m, 1e-12);
    EXPECT_EQ(correction.pose_stamp(), ros::Time(pose_s));
  }

  double heard_from_s = 0.0, heard_up_to_s = 0.0;
  OdomCorrection correction{[this](const ros::Time& stamp) { return lookUp(stamp); }, kWait_s};
};

TEST_F(OdomCorrectionTest, UsesAPoseThatTfHasReachedAtOnce) {
  heard_up_to_s = 10.0;
  setPose(10.0, 0.5);
  expectDrift(0.5, 10.0);
  EXPECT_FALSE(correction.problem());
}

TEST_F(OdomCorrectionTest, FollowsThePosesWhereTfIsLateByMoreThanTheTimeBetweenThem) {
  for (const double late_s : {0.06, 0.3, 0.7}) {
    SCOPED_TRACE(late_s);
    correction.reset();
    for (int i = 0; i < 400; ++i) {
      const double time_s = 10.0 + 0.025 * i;
      heard_up_to_s = time_s - late_s;
      setPose(time_s, time_s);
      EXPECT_FALSE(correction.problem());
      if (time_s < 10.0 + late_s + 0.025) continue;
      ASSERT_TRUE(correction.T_map_odom());
      EXPECT_GE(correction.pose_stamp().toSec(), time_s - late_s - 0.026);
    }
  }
}

TEST_F(OdomCorrectionTest, FollowsNowAndThenWhereTfIsVeryLate) {
  std::size_t changes = 0;
  for (int i = 0; i < 4000; ++i) {
    const double time_s = 10.0 + 0.025 * i;
    heard_up_to_s = time_s - 5.0;
    const ros::Time before = correction.pose_stamp();
    setPose(time_s, time_s);
    if (correction.pose_stamp() != before) ++changes;
  }
  EXPECT_GT(changes, 20U);
  EXPECT_GE(correction.pose_stamp().toSec(), 110.0 - 11.0);
}

TEST_F(OdomCorrectionTest, UsesTheNewestOfThePosesThatTfReachesTogether) {
  for (const double t : {10.0, 10.1, 10.2, 10.3}) setPose(t, t);
  EXPECT_FALSE(correction.T_map_odom());
  heard_up_to_s = 10.25;
  correction.update(10.3);
  expectDrift(10.2, 10.2);
  heard_up_to_s = 10.4;
  correction.update(10.4);
  expectDrift(10.3, 10.3);
}

TEST_F(OdomCorrectionTest, APoseFromBeforeTheOdometryDoesNotHoldUpThoseAfterIt) {
  heard_from_s = 10.05;
  setPose(10.0, 1.0);
  heard_up_to_s = 10.1;
  setPose(10.1, 2.0);
  expectDrift(2.0, 10.1);
}

TEST_F(OdomCorrectionTest, TellsOfTfThatDoesNotComeOnceItHasWaited) {
  for (int i = 0; i < 39; ++i) setPose(10.0 + 0.025 * i, 0.0);
  EXPECT_FALSE(correction.problem());
  setPose(11.0, 0.0);
  ASSERT_TRUE(correction.problem());
  EXPECT_EQ(*correction.problem(), "extrapolation");
  heard_up_to_s = 11.0;
  correction.update(11.1);
  EXPECT_FALSE(correction.problem());
}

TEST_F(OdomCorrectionTest, ForgetsWhatWaitsWhenAnotherRecordingBegins) {
  setPose(10.0, 1.0);
  correction.reset();
  heard_up_to_s = 20.0;
  correction.update(20.0);
  EXPECT_FALSE(correction.T_map_odom());
}

}  // namespace
}  // namespace hymm
