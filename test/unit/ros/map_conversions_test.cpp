#include "ros/map_conversions.h"

#include <cmath>

#include <gmock/gmock.h>

#include "ros/filter_conversions.h"
#include "ros/joint_covariance.h"
#include "ros/time_conversions.h"

namespace hymm {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

core::LandmarkEstimate landmark(int id) {
  core::LandmarkEstimate landmark;
  landmark.id = id;
  landmark.type = core::LandmarkType::kReflector;
  landmark.position = {1.5 + id, -2.25};
  landmark.covariance << 0.04, 0.01, 0.01, 0.09;
  landmark.diameter_m = std::nan("");
  landmark.diameter_variance = std::nan("");
  landmark.observations = 7;
  landmark.last_seen_s = 12.5;
  landmark.first_seen_s = 3.25;
  return landmark;
}

TEST(MapConversions, LandmarkMapSurvivesTheWayThroughAMessage) {
  core::LandmarkMap map;
  map.version = 42;
  map.time_s = 13.0;
  map.landmarks = {landmark(3), landmark(8)};
  map.merges = {{5, 3}};
  Eigen::Matrix2d block;
  block << 1.0, 2.0, 3.0, 4.0;
  map.cross_covariances = {{3, 8, block}};

  const LandmarkMap message = toMessage(map, 30.0, "map");
  EXPECT_EQ(message.header.frame_id, "map");
  EXPECT_EQ(message.block_range, 30.0);
  const core::LandmarkMap back = fromMessage(message);

  EXPECT_EQ(back.version, 42U);
  EXPECT_EQ(back.time_s, 13.0);
  ASSERT_EQ(back.landmarks.size(), 2U);
  EXPECT_EQ(back.landmarks[1].id, 8);
  EXPECT_EQ(back.landmarks[1].type, core::LandmarkType::kReflector);
  EXPECT_EQ(back.landmarks[1].position, map.landmarks[1].position);
  EXPECT_EQ(back.landmarks[1].covariance, map.landmarks[1].covariance);
  EXPECT_TRUE(std::isnan(back.landmarks[1].diameter_m));
  EXPECT_EQ(back.landmarks[1].observations, 7);
  EXPECT_EQ(back.landmarks[1].last_seen_s, 12.5);
  EXPECT_EQ(back.landmarks[1].first_seen_s, 3.25);
  ASSERT_EQ(back.merges.size(), 1U);
  EXPECT_EQ(back.merges[0].from_id, 5);
  EXPECT_EQ(back.merges[0].into_id, 3);
  ASSERT_EQ(back.cross_covariances.size(), 1U);
  EXPECT_EQ(back.cross_covariances[0].block, block);
}

GetJointCovariance::Request requestFor(const std::vector<int>& ids) {
  GetJointCovariance::Request request;
  request.ids.assign(ids.begin(), ids.end());
  return request;
}

TEST(JointCovariance, MatrixIsWrittenRowByRow) {
  core::JointLandmarks joint;
  joint.version = 5;
  joint.time_s = 2.5;
  joint.ids = {7, 3};
  joint.mean = Eigen::Vector4d(1.0, 2.0, 3.0, 4.0);
  joint.covariance.resize(4, 4);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) joint.covariance(row, column) = 10 * row + column;
  }
  const GetJointCovariance::Response response = toMessage(joint, "map");
  EXPECT_TRUE(response.success);
  EXPECT_EQ(response.version, 5U);
  EXPECT_EQ(response.header.frame_id, "map");
  EXPECT_EQ(response.header.stamp, ros::Time(2.5));
  EXPECT_THAT(response.mean, ElementsAre(1.0, 2.0, 3.0, 4.0));
  EXPECT_THAT(response.covariance,
              ElementsAre(0, 1, 2, 3, 10, 11, 12, 13, 20, 21, 22, 23, 30, 31, 32, 33));
}

TEST(JointCovariance, NamesWhatCannotBeAnswered) {
  const auto below_ten = [](int id) { return id >= 0 && id < 10; };
  EXPECT_EQ(problemOf(requestFor({3, 7}), below_ten), "");
  EXPECT_THAT(problemOf(requestFor({3, 12, -1, 7}), below_ten), HasSubstr("no landmark -1, 12 "));
  EXPECT_THAT(problemOf(requestFor({3, 7, 3}), below_ten), HasSubstr("more than once: 3;"));
  EXPECT_THAT(problemOf(requestFor({}), below_ten), HasSubstr("at least one"));
  EXPECT_THAT(problemOf(requestFor(std::vector<int>(1001, 3)), below_ten),
              HasSubstr("at most 1000"));
}

TEST(FilterConversions, PoseKeepsPlaceAndCovariance) {
  core::PoseEstimate estimate;
  estimate.time_s = 7.0;
  estimate.T_map_base = {10.0, -20.0, 3.0};
  estimate.covariance << 1.0, 0.1, 0.2, 0.1, 2.0, 0.3, 0.2, 0.3, 3.0;
  estimate.map_version = 9;
  estimate.sweep.pieces = {{0.0, 5.0, 0.1, 0.5}, {0.025, 4.0, 0.0, -0.5}};
  const core::PoseEstimate back = fromMessage(toMessage(estimate, "map"));
  EXPECT_EQ(back.T_map_base.x_m, 10.0);
  EXPECT_EQ(back.T_map_base.y_m, -20.0);
  EXPECT_NEAR(back.T_map_base.yaw_rad, 3.0, 1e-15);
  EXPECT_EQ(back.covariance, estimate.covariance);
  EXPECT_EQ(back.map_version, 9U);
  ASSERT_EQ(back.sweep.pieces.size(), 2U);
  EXPECT_EQ(back.sweep.pieces[1].from_s, 0.025);
  EXPECT_EQ(back.sweep.pieces[1].yaw_rate_radps, -0.5);
  EXPECT_EQ(back.sweep.poseAfter(0.1).vector(), estimate.sweep.poseAfter(0.1).vector());
}

TEST(TimeConversions, WhatAStampCannotHoldIsNoStamp) {
  EXPECT_TRUE(toRosTime(-1.0).isZero());
  EXPECT_TRUE(toRosTime(std::nan("")).isZero());
  EXPECT_TRUE(toRosTime(1e12).isZero());
  EXPECT_EQ(toRosTime(1.25), ros::Time(1, 250000000));
}

TEST(JointCovariance, VehicleAmongLandmarksSurvivesTheWayThroughAMessage) {
  core::FilterKnowledge knowledge;
  core::VehicleAmongLandmarks& estimate = knowledge.estimate;
  estimate.landmarks.version = 9;
  estimate.landmarks.time_s = 12.5;
  estimate.landmarks.ids = {4, 2};
  estimate.landmarks.mean = Eigen::Vector4d(1.0, 2.0, 3.0, 4.0);
  estimate.landmarks.covariance = Eigen::Vector4d(0.1, 0.2, 0.3, 0.4).asDiagonal();
  estimate.landmarks.covariance(0, 3) = estimate.landmarks.covariance(3, 0) = 0.05;
  estimate.vehicle.mean = {5.0, -6.0, 0.5};
  estimate.vehicle.covariance = Eigen::Vector3d(0.5, 0.6, 0.07).asDiagonal();
  estimate.cross_covariance = Eigen::MatrixXd::Zero(3, 4);
  estimate.cross_covariance(2, 1) = 0.03;
  knowledge.calibration = {1.02, 0.98, 0.004};

  const auto message = toMessage(knowledge, "map");
  const auto back = fromMessage(message, {4, 2});
  ASSERT_TRUE(back);
  EXPECT_EQ(back->estimate.landmarks.mean, estimate.landmarks.mean);
  EXPECT_EQ(back->estimate.landmarks.covariance, estimate.landmarks.covariance);
  EXPECT_EQ(back->estimate.landmarks.time_s, 12.5);
  EXPECT_EQ(back->estimate.cross_covariance, estimate.cross_covariance);
  EXPECT_EQ(back->estimate.vehicle.covariance, estimate.vehicle.covariance);
  EXPECT_NEAR(back->estimate.vehicle.mean.yaw_rad, 0.5, 1e-12);
  EXPECT_EQ(back->calibration.vector(), knowledge.calibration.vector());
}

TEST(JointCovariance, AnswerOfTheWrongSizeIsRefused) {
  core::FilterKnowledge knowledge;
  knowledge.estimate.landmarks.ids = {4};
  knowledge.estimate.landmarks.mean = Eigen::Vector2d(1.0, 2.0);
  knowledge.estimate.landmarks.covariance = Eigen::Matrix2d::Identity();
  knowledge.estimate.cross_covariance = Eigen::MatrixXd::Zero(3, 2);
  const auto message = toMessage(knowledge, "map");
  EXPECT_TRUE(fromMessage(message, {4}));
  EXPECT_FALSE(fromMessage(message, {4, 5}));
}

}  // namespace
}  // namespace hymm
