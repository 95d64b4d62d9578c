#include "ros/sensor_conversions.h"

#include <cmath>

#include <gmock/gmock.h>

#include "ros/odometry_conversions.h"
#include "ros/pose_conversions.h"

namespace hymm {
namespace {

using testing::SizeIs;

TEST(SensorConversions, ScanSurvivesTheWayThroughAMessage) {
  core::LaserScan scan;
  scan.time_s = 12.5;
  scan.time_increment_s = 0.125;
  scan.angle_min_rad = -1.5;
  scan.angle_increment_rad = 0.5;
  scan.range_min_m = 0.25;
  scan.range_max_m = 80.0;
  scan.ranges_m = {1.0F, INFINITY, -INFINITY, 4.0F};
  scan.intensities = {0.0F, 1.0F, 2.0F, 3.0F};
  const sensor_msgs::LaserScan message = toMessage(scan, "laser");
  EXPECT_EQ(message.header.frame_id, "laser");
  EXPECT_EQ(message.angle_max, 0.0F);
  const core::LaserScan back = fromMessage(message);
  EXPECT_EQ(back.time_s, 12.5);
  EXPECT_EQ(back.time_increment_s, 0.125);
  EXPECT_EQ(back.angle_min_rad, -1.5);
  EXPECT_EQ(back.angle_increment_rad, 0.5);
  EXPECT_EQ(back.range_min_m, 0.25);
  EXPECT_EQ(back.range_max_m, 80.0);
  EXPECT_EQ(back.ranges_m, scan.ranges_m);
  EXPECT_EQ(back.intensities, scan.intensities);
}

TEST(SensorConversions, EncodersSurviveTheWayThroughAMessage) {
  const core::AckermannInput back =
      fromMessage(toMessage(core::AckermannInput{2.5, 3.0, -0.125}, "base_link"));
  EXPECT_EQ(back.time_s, 2.5);
  EXPECT_EQ(back.speed_mps, 3.0);
  EXPECT_EQ(back.steering_rad, -0.125);
}

TEST(SensorConversions, OfOdometryTheTwistIsTaken) {
  nav_msgs::Odometry message;
  message.header.stamp = ros::Time(2.5);
  message.pose.pose.position.x = 99.0;
  message.twist.twist.linear.x = 1.0;
  message.twist.twist.linear.y = 2.0;
  message.twist.twist.angular.z = 3.0;
  const core::TwistInput input = fromMessage(message);
  EXPECT_EQ(input.time_s, 2.5);
  EXPECT_EQ(input.forward_mps, 1.0);
  EXPECT_EQ(input.lateral_mps, 2.0);
  EXPECT_EQ(input.yaw_rate_radps, 3.0);
}

TEST(SensorConversions, ObservationsSurviveTheWayThroughAMessage) {
  core::ObservationSet set;
  set.time_s = 2.5;
  set.observations.resize(2);
  core::Observation& observation = set.observations[1];
  observation.range_m = 12.0;
  observation.bearing_rad = -0.5;
  observation.covariance << 0.04, 0.001, 0.002, 0.0001;
  observation.type = core::LandmarkType::kReflector;
  observation.diameter_m = 0.25;
  observation.diameter_variance = 0.01;
  observation.identity = 42;
  const core::ObservationSet back = fromMessage(toMessage(set, "laser"));
  EXPECT_EQ(back.time_s, 2.5);
  ASSERT_THAT(back.observations, SizeIs(2));
  EXPECT_TRUE(std::isnan(back.observations[0].diameter_m));
  EXPECT_EQ(back.observations[0].identity, -1);
  EXPECT_EQ(back.observations[1].range_m, 12.0);
  EXPECT_EQ(back.observations[1].bearing_rad, -0.5);
  EXPECT_EQ(back.observations[1].covariance, observation.covariance);
  EXPECT_EQ(back.observations[1].type, core::LandmarkType::kReflector);
  EXPECT_EQ(back.observations[1].diameter_m, 0.25);
  EXPECT_EQ(back.observations[1].identity, 42);
}

TEST(SensorConversions, ATypeThatNobodyKnowsIsUnknown) {
  EXPECT_EQ(landmarkType(LandmarkObservation::TYPE_TRUNK), core::LandmarkType::kTrunk);
  EXPECT_EQ(landmarkType(200), core::LandmarkType::kUnknown);
}

TEST(PoseConversions, PosesSurviveTheWayThroughAMessage) {
  for (const double yaw_rad : {-3.0, -0.5, 0.0, 1.0, 3.1}) {
    const core::Pose2 pose{1.5, -2.5, yaw_rad};
    EXPECT_LT((fromMessage(toPoseMessage(pose)).vector() - pose.vector()).norm(), 1e-15);
    EXPECT_LT((fromMessage(toTransformMessage(pose)).vector() - pose.vector()).norm(), 1e-15);
  }
}

TEST(PoseConversions, YawOfATiltedQuaternionIsItsHeading) {
  geometry_msgs::Quaternion q;  // yaw 1, then roll 0.2 about the vehicle's own x axis
  q.w = std::cos(0.5) * std::cos(0.1);
  q.x = std::cos(0.5) * std::sin(0.1);
  q.y = std::sin(0.5) * std::sin(0.1);
  q.z = std::sin(0.5) * std::cos(0.1);
  EXPECT_NEAR(yawOf(q), 1.0, 1e-12);
}

TEST(PoseConversions, CovarianceStandsAtXYAndYaw) {
  Eigen::Matrix3d covariance;
  covariance << 1, 2, 3, 2, 4, 5, 3, 5, 6;
  const auto message = toMessage(core::Pose2{}, covariance);
  EXPECT_EQ(message.covariance[0], 1.0);
  EXPECT_EQ(message.covariance[1], 2.0);
  EXPECT_EQ(message.covariance[5], 3.0);
  EXPECT_EQ(message.covariance[35], 6.0);
  EXPECT_EQ(message.covariance[14], 0.0);  // z
  EXPECT_EQ(planarCovariance(message), covariance);
}

TEST(OdometryConversions, TellPoseAndVelocityOfDeadReckoning) {
  core::VehicleConfig vehicle;
  core::DeadReckoning dead_reckoning(vehicle);
  dead_reckoning.process(core::TwistInput{1.0, 2.0, 0.0, 0.5});
  dead_reckoning.process(core::TwistInput{3.0, 1.0, 0.25, -0.5});
  const nav_msgs::Odometry odometry = odometryMessage(dead_reckoning, vehicle);
  EXPECT_EQ(odometry.header.stamp, ros::Time(3.0));
  EXPECT_EQ(odometry.header.frame_id, "odom");
  EXPECT_EQ(odometry.child_frame_id, "base_link");
  EXPECT_NEAR(yawOf(odometry.pose.pose.orientation), 1.0, 1e-9);
  EXPECT_EQ(odometry.twist.twist.linear.x, 1.0);
  EXPECT_EQ(odometry.twist.twist.linear.y, 0.25);
  EXPECT_EQ(odometry.twist.twist.angular.z, -0.5);
  EXPECT_GT(odometry.pose.covariance[0], 0.0);
  EXPECT_GT(odometry.twist.covariance[0], 0.0);
  const auto transform = odometryTransform(dead_reckoning, vehicle);
  EXPECT_EQ(transform.header.frame_id, "odom");
  EXPECT_EQ(transform.child_frame_id, "base_link");
  EXPECT_EQ(transform.transform.translation.x, odometry.pose.pose.position.x);
  EXPECT_EQ(transform.transform.rotation.z, odometry.pose.pose.orientation.z);
}

}  // namespace
}  // namespace hymm
