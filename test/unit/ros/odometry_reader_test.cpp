#include "ros/odometry_reader.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>

#include "ros/pose_conversions.h"

namespace hymm {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Key;
using testing::Not;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kPi = 3.14159265358979323846;

class OdometryReaderTest : public testing::Test {
 protected:
  static nav_msgs::Odometry at(double time_s, const core::Pose2& T_odom_base) {
    nav_msgs::Odometry message;
    message.header.stamp = ros::Time(time_s);
    message.header.frame_id = "odom";
    message.child_frame_id = "base_link";
    message.pose.pose = toPoseMessage(T_odom_base);
    return message;
  }
  static nav_msgs::Odometry at(double time_s, const core::Pose2& T_odom_base, double forward_mps,
                               double lateral_mps, double yaw_rate_radps) {
    nav_msgs::Odometry message = at(time_s, T_odom_base);
    message.twist.twist.linear.x = forward_mps;
    message.twist.twist.linear.y = lateral_mps;
    message.twist.twist.angular.z = yaw_rate_radps;
    return message;
  }
  /// Around a circle to the left at 1 m/s and 0.2 rad/s.
  static core::Pose2 onCircle(double time_s) {
    const double a = 0.2 * time_s;
    return {5.0 * std::sin(a), 5.0 * (1.0 - std::cos(a)), core::wrapAngle(a)};
  }
  std::optional<core::TwistInput> read(const nav_msgs::Odometry& message) {
    return reader_.read(message, mountings_, 0.0, causes_).input;
  }
  void place(const std::string& frame, double x_m, double y_m, double yaw_rad) {
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = "base_link";
    transform.child_frame_id = frame;
    transform.transform = toTransformMessage({x_m, y_m, yaw_rad});
    tf_.setTransform(transform, "test", true);
  }
  static void expectVelocity(const std::optional<core::TwistInput>& input, double forward_mps,
                             double lateral_mps, double yaw_rate_radps) {
    ASSERT_TRUE(input);
    EXPECT_NEAR(input->forward_mps, forward_mps, 1e-6);
    EXPECT_NEAR(input->lateral_mps, lateral_mps, 1e-6);
    EXPECT_NEAR(input->yaw_rate_radps, yaw_rate_radps, 1e-6);
  }

  CauseLog causes_;
  tf2::BufferCore tf_;
  SensorMountings mountings_{tf_, "base_link", std::nullopt, 0.0};
  OdometryReader reader_;
};

TEST_F(OdometryReaderTest, TwoPosesGiveTheVelocityThatLeadsFromOneToTheOther) {
  // Far from the origin, along an arc of radius 10 m at 2 m/s.
  const core::Pose2 T_utm{334000.0, 6251000.0, 1.0};
  const auto on_arc = [&](double angle) {
    return T_utm * core::Pose2{10.0 * std::sin(angle), 10.0 * (1.0 - std::cos(angle)), angle};
  };
  EXPECT_FALSE(read(at(1.0, on_arc(0.0))));
  const auto input = read(at(1.5, on_arc(0.1)));
  expectVelocity(input, 2.0, 0.0, 0.2);
  EXPECT_EQ(input->time_s, 1.0);
  EXPECT_EQ(input->until_s, 1.5);
  EXPECT_THAT(causes_.counts(), Contains(Key("odometry without twist")));
}

TEST_F(OdometryReaderTest, AMeanStampedAtItsEndCountsForTheTimeThatEnded) {
  read(at(1.0, {}, 0.0, 0.0, 0.0));
  const auto turning = read(at(1.2, {0.0, 0.0, 0.1}, 0.0, 0.0, 0.5));
  expectVelocity(turning, 0.0, 0.0, 0.5);
  EXPECT_EQ(turning->time_s, 1.0);
  EXPECT_EQ(turning->until_s, 1.2);
  EXPECT_THAT(causes_.counts(), IsEmpty());
}

TEST_F(OdometryReaderTest, WithoutPosesTheTwistCounts) {
  read(at(5.0, {}, 2.0, 0.0, 0.0));
  const auto input = read(at(5.1, {}, 3.0, 0.5, 0.2));
  expectVelocity(input, 2.5, 0.25, 0.1);  // of moments: the mean over the time between
  EXPECT_EQ(input->time_s, 5.0);
  EXPECT_EQ(input->until_s, 5.1);
  expectVelocity(read(at(5.2, {kNan, 0.0, 0.0}, 3.0, 0.5, 0.2)), 3.0, 0.5, 0.2);
  EXPECT_THAT(causes_.counts(), IsEmpty());
}

TEST_F(OdometryReaderTest, ATwistInTheAxesOfTheWorldIsToldAndDoesNoHarm) {
  for (int i = 0; i < 200; ++i) {
    const double time_s = 0.1 * i, yaw = 0.2 * time_s;
    const auto input = read(at(1.0 + time_s, onCircle(time_s), std::cos(yaw), std::sin(yaw), 0.2));
    if (i > 0) expectVelocity(input, 1.0, 0.0, 0.2);
  }
  EXPECT_THAT(causes_.counts(), Contains(Key("odometry whose twist contradicts its poses")));
}

TEST_F(OdometryReaderTest, ATwistOfTheYawRateAloneOrInDegreesIsToldAndDoesNoHarm) {
  for (const double in_degrees : {0.0, 1.0}) {
    reader_.reset();
    const std::size_t told = causes_.total();
    for (int i = 0; i < 200; ++i) {
      const auto input = read(at(1.0 + 0.1 * i, onCircle(0.1 * i), in_degrees, 0.0,
                                 in_degrees > 0.0 ? 0.2 * 180.0 / kPi : 0.2));
      if (i > 0) expectVelocity(input, 1.0, 0.0, 0.2);
    }
    EXPECT_GT(causes_.total(), told);
  }
  EXPECT_THAT(causes_.counts(), Contains(Key("odometry whose twist contradicts its poses")));
}

TEST_F(OdometryReaderTest, ATwistThatFitsThePosesIsNotToldOf) {
  for (int i = 0; i < 600; ++i) {  // 3 % apart, and a filter of 0.1 s behind
    read(at(1.0 + 0.1 * i, onCircle(0.1 * i), 1.03, 0.0, i > 0 ? 0.2 : 0.0));
  }
  EXPECT_THAT(causes_.counts(), IsEmpty());
}

TEST_F(OdometryReaderTest, ATwistThatFitsIsNotToldOfBecauseItIsSeldom) {
  // Means over the past second, while the vehicle gains 4 m/s in a second; then a gap, in which it
  // turns and comes back.
  read(at(1.0, {}, 0.0, 0.0, 0.0));
  read(at(2.0, {2.0, 0.0, 0.0}, 2.0, 0.0, 0.0));
  read(at(3.0, {6.0, 0.0, 0.0}, 4.0, 0.0, 0.0));
  read(at(4.0, {10.0, 0.0, 0.0}, 4.0, 0.0, 0.0));
  read(at(24.0, {12.0, 0.0, 0.0}, 4.0, 0.0, 0.0));
  read(at(25.0, {16.0, 0.0, 0.0}, 4.0, 0.0, 0.0));
  read(at(26.0, {20.0, 0.0, 0.0}, 4.0, 0.0, 0.0));
  EXPECT_THAT(causes_.counts(), IsEmpty());
}

TEST_F(OdometryReaderTest, ATwistThatIsNotFiniteIsToldAndThePosesCount) {
  read(at(1.0, {}, 1.0, 0.0, kNan));
  expectVelocity(read(at(1.1, {0.1, 0.0, 0.0}, 1.0, 0.0, kNan)), 1.0, 0.0, 0.0);
  EXPECT_THAT(causes_.counts(), Contains(Key("odometry whose twist is not finite")));
}

TEST_F(OdometryReaderTest, AVehicleThatStandsAtFirstIsNoSourceWithoutTwist) {
  read(at(1.0, {}));
  expectVelocity(read(at(1.1, {})), 0.0, 0.0, 0.0);
  expectVelocity(read(at(1.2, {0.2, 0.0, 0.0}, 2.0, 0.0, 0.0)), 2.0, 0.0, 0.0);
  EXPECT_THAT(causes_.counts(), IsEmpty());
}

TEST_F(OdometryReaderTest, APoseThatIsSetAnewIsNoMotion) {
  read(at(1.0, {}));
  EXPECT_FALSE(read(at(1.1, {500.0, 0.0, 0.0})));
  EXPECT_THAT(causes_.counts(), Contains(Key("odometry set anew")));
  EXPECT_NEAR(read(at(1.2, {500.1, 0.0, 0.0}))->forward_mps, 1.0, 1e-6);
}

TEST_F(OdometryReaderTest, AStepOfThePoseThatNothingExplainsIsBridgedByTheTwist) {
  for (int i = 0; i < 20; ++i) read(at(1.0 + 0.1 * i, {0.1 * i, 0.0, 0.0}, 1.0, 0.0, 0.0));
  // Corrected by half a metre to the left and 0.5 rad, as by GPS; then it goes on from there.
  expectVelocity(read(at(3.0, {2.0, 0.5, 0.5}, 1.2, 0.0, 0.0)), 1.1, 0.0, 0.0);
  EXPECT_THAT(causes_.counts(), Contains(Key("odometry set anew")));
  const core::Pose2 next = core::Pose2{2.0, 0.5, 0.5} * core::Pose2{0.12, 0.0, 0.0};
  expectVelocity(read(at(3.1, next, 1.2, 0.0, 0.0)), 1.2, 0.0, 0.0);
}

TEST_F(OdometryReaderTest, AStepOfPosesWithoutTwistIsBridgedByTheVelocityBefore) {
  for (int i = 0; i < 20; ++i) read(at(1.0 + 0.05 * i, {0.2 * i, 0.0, 0.0}));
  expectVelocity(read(at(2.0, {7.0, 0.0, 0.35})), 4.0, 0.0, 0.0);
  EXPECT_THAT(causes_.counts(), Contains(Key("odometry set anew")));
}

TEST_F(OdometryReaderTest, AVehicleThatBrakesAndTurnsHardIsBelieved) {
  // 8 m/s^2 and 6 rad/s^2 at 10 Hz, and the twist tells of it.
  core::Pose2 pose;
  double speed_mps = 6.0, rate_radps = 0.0;
  read(at(1.0, pose, speed_mps, 0.0, rate_radps));
  for (int i = 1; i <= 7; ++i) {
    speed_mps -= 0.8;
    rate_radps += 0.6;
    pose = pose * core::Pose2{0.1 * speed_mps, 0.0, 0.1 * rate_radps};
    ASSERT_TRUE(read(at(1.0 + 0.1 * i, pose, speed_mps, 0.0, rate_radps)));
  }
  EXPECT_THAT(causes_.counts(), Not(Contains(Key("odometry set anew"))));
}

TEST_F(OdometryReaderTest, ThePosesOfACoarseEncoderAddUpToTheWay) {
  double moved_m = 0.0;
  for (int i = 0; i <= 1000; ++i) {  // 0.1 m/s at 50 Hz in ticks of 1 cm; the twist is smooth
    const double ticks = std::floor(100.0 * (0.1 * 0.02 * i));
    const auto input = read(at(1.0 + 0.02 * i, {0.01 * ticks, 0.0, 0.0}, 0.1, 0.0, 0.0));
    if (input) moved_m += input->forward_mps * (*input->until_s - input->time_s);
  }
  EXPECT_NEAR(moved_m, 2.0, 0.011);  // a tick
  EXPECT_THAT(causes_.counts(), IsEmpty());
}

TEST_F(OdometryReaderTest, PosesThatStopWhileTheTwistGoesOnAreReplacedAndTold) {
  for (int i = 0; i < 20; ++i) read(at(1.0 + 0.1 * i, {0.1 * i, 0.0, 0.0}, 1.0, 0.0, 0.0));
  double moved_m = 0.0;
  for (int i = 0; i < 50; ++i) {
    const auto input = read(at(3.0 + 0.1 * i, {1.9, 0.0, 0.0}, 1.0, 0.0, 0.0));
    moved_m += input->forward_mps * (*input->until_s - input->time_s);
  }
  EXPECT_NEAR(moved_m, 5.0, 0.11);  // what may have been the time between two ticks is lost
  EXPECT_THAT(causes_.counts(), Contains(Key("odometry whose poses stand still")));
}

TEST_F(OdometryReaderTest, WithoutTwistAndWithoutAPoseIsRefused) {
  EXPECT_FALSE(read(at(1.0, {kNan, 0.0, 0.0}, kNan, 0.0, 0.0)));
  EXPECT_THAT(causes_.counts(), Contains(Key("odometry refused")));
}

TEST_F(OdometryReaderTest, TimeThatStandsOrRunsBackGivesNothing) {
  read(at(5.0, {}));
  EXPECT_FALSE(read(at(5.0, {0.1, 0.0, 0.0})));
  EXPECT_FALSE(read(at(1.0, {0.2, 0.0, 0.0})));
  EXPECT_TRUE(read(at(1.1, {0.3, 0.0, 0.0})));
}

TEST_F(OdometryReaderTest, AMessageFromThePastIsNoPlaceToGoOnFrom) {
  read(at(5.0, {}));
  EXPECT_FALSE(read(at(2.0, {-3.0, 0.0, 0.0})));
  const auto input = read(at(5.1, {0.1, 0.0, 0.0}));
  expectVelocity(input, 1.0, 0.0, 0.0);
  EXPECT_EQ(input->time_s, 5.0);
}

TEST_F(OdometryReaderTest, AFrameThatLooksBackIsTurnedByWhatTfSays) {
  place("camera", 0.0, 0.0, kPi);
  const auto camera = [&](nav_msgs::Odometry message) {
    message.child_frame_id = "/camera";
    return message;
  };
  read(camera(at(1.0, {}, -2.0, 0.0, 0.0)));
  expectVelocity(read(camera(at(1.1, {-0.2, 0.0, 0.0}, -2.0, 0.0, 0.0))), 2.0, 0.0, 0.0);
  expectVelocity(read(camera(at(1.2, {kNan, 0.0, 0.0}, -2.0, 0.0, 0.0))), 2.0, 0.0, 0.0);
  EXPECT_THAT(causes_.counts(), IsEmpty());
}

TEST_F(OdometryReaderTest, AFrameAwayFromTheVehiclesMovesAlongWhenItTurns) {
  place("camera", 1.0, 0.5, 0.5 * kPi);
  const core::Pose2 T_base_camera{1.0, 0.5, 0.5 * kPi};
  // The vehicle turns on the spot at 0.2 rad/s: the camera runs at 0.2 * (1, 0.5) m across.
  const auto turned = [&](double time_s) {
    const core::Pose2 T_odom_base{0.0, 0.0, 0.2 * time_s};
    nav_msgs::Odometry message = at(1.0 + time_s, T_odom_base * T_base_camera, 0.2, 0.1, 0.2);
    message.child_frame_id = "camera";
    return message;
  };
  read(turned(0.0));
  expectVelocity(read(turned(0.1)), 0.0, 0.0, 0.2);
  nav_msgs::Odometry without_pose = turned(0.2);
  without_pose.pose.pose.position.x = kNan;
  expectVelocity(read(without_pose), 0.0, 0.0, 0.2);
}

TEST_F(OdometryReaderTest, AFrameThatTfDoesNotKnowIsTakenForTheVehiclesAndNamed) {
  nav_msgs::Odometry message = at(1.0, {});
  message.child_frame_id = "imu";
  EXPECT_FALSE(read(message));
  message = at(1.1, {0.1, 0.0, 0.0});
  message.child_frame_id = "imu";
  expectVelocity(read(message), 1.0, 0.0, 0.0);
  EXPECT_THAT(causes_.counts(), Contains(Key(HasSubstr("'imu'"))));
}

TEST_F(OdometryReaderTest, AFrameThatTfMayYetTellIsWaitedFor) {
  SensorMountings patient(tf_, "base_link", std::nullopt, 5.0);
  nav_msgs::Odometry message = at(1.0, {});
  message.child_frame_id = "imu";
  EXPECT_TRUE(reader_.read(message, patient, 0.0, causes_).waiting);
  EXPECT_THAT(causes_.counts(), IsEmpty());
  EXPECT_FALSE(reader_.read(message, patient, 6.0, causes_).waiting);
}

}  // namespace
}  // namespace hymm
