#include "ros/odometry_reader.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>

#include "ros/pose_conversions.h"

namespace hymm {
namespace {

using testing::Contains;
using testing::IsEmpty;
using testing::Key;

class OdometryReaderTest : public testing::Test {
 protected:
  static nav_msgs::Odometry at(double time_s, const core::Pose2& T_odom_base) {
    nav_msgs::Odometry message;
    message.header.stamp = ros::Time(time_s);
    message.pose.pose = toPoseMessage(T_odom_base);
    return message;
  }
  std::optional<core::TwistInput> read(const nav_msgs::Odometry& message) {
    return reader_.read(message, causes_);
  }

  CauseLog causes_;
  OdometryReader reader_;
};

TEST_F(OdometryReaderTest, TakesTheTwistAsItIs) {
  nav_msgs::Odometry message = at(5.0, {});
  message.twist.twist.linear.x = 2.0;
  const auto input = read(message);
  ASSERT_TRUE(input);
  EXPECT_EQ(input->time_s, 5.0);
  EXPECT_EQ(input->forward_mps, 2.0);
  message.header.stamp = ros::Time(5.1);
  message.twist.twist.linear.x = 0.0;  // it stops; where its pose is set counts no more
  message.pose.pose.position.x = 9.0;
  EXPECT_EQ(read(message)->forward_mps, 0.0);
  EXPECT_THAT(causes_.counts(), IsEmpty());
}

TEST_F(OdometryReaderTest, PosesWithoutTwistGiveTheVelocityThatLeadsFromOneToTheNext) {
  // Far from the origin, along an arc of radius 10 m at 2 m/s.
  const core::Pose2 T_utm{334000.0, 6251000.0, 1.0};
  const auto on_arc = [&](double angle) {
    return T_utm * core::Pose2{10.0 * std::sin(angle), 10.0 * (1.0 - std::cos(angle)), angle};
  };
  EXPECT_FALSE(read(at(1.0, on_arc(0.0))));
  const auto input = read(at(1.5, on_arc(0.1)));
  ASSERT_TRUE(input);
  EXPECT_EQ(input->time_s, 1.0);
  EXPECT_NEAR(input->forward_mps, 2.0, 1e-6);
  EXPECT_NEAR(input->lateral_mps, 0.0, 1e-6);
  EXPECT_NEAR(input->yaw_rate_radps, 0.2, 1e-9);
  EXPECT_THAT(causes_.counts(), Contains(Key("odometry without twist")));
}

TEST_F(OdometryReaderTest, AVehicleThatStandsAtFirstIsNoSourceWithoutTwist) {
  read(at(1.0, {}));
  const auto standing = read(at(1.1, {}));
  ASSERT_TRUE(standing);
  EXPECT_EQ(standing->forward_mps, 0.0);
  nav_msgs::Odometry message = at(1.2, {0.2, 0.0, 0.0});
  message.twist.twist.linear.x = 2.0;
  EXPECT_EQ(read(message)->time_s, 1.2);
  EXPECT_THAT(causes_.counts(), IsEmpty());
}

TEST_F(OdometryReaderTest, APoseThatIsSetAnewIsNoMotion) {
  read(at(1.0, {}));
  EXPECT_FALSE(read(at(1.1, {500.0, 0.0, 0.0})));
  EXPECT_THAT(causes_.counts(), Contains(Key("odometry set anew")));
  EXPECT_NEAR(read(at(1.2, {500.1, 0.0, 0.0}))->forward_mps, 1.0, 1e-6);
}

TEST_F(OdometryReaderTest, WithoutTwistAndWithoutAPoseIsRefused) {
  EXPECT_FALSE(read(at(1.0, {std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0})));
  EXPECT_THAT(causes_.counts(), Contains(Key("odometry refused")));
}

TEST_F(OdometryReaderTest, TimeThatStandsOrRunsBackGivesNothing) {
  read(at(5.0, {}));
  EXPECT_FALSE(read(at(5.0, {0.1, 0.0, 0.0})));
  EXPECT_FALSE(read(at(1.0, {0.2, 0.0, 0.0})));
  EXPECT_TRUE(read(at(1.1, {0.3, 0.0, 0.0})));
}

}  // namespace
}  // namespace hymm
