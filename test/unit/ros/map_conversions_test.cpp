#include "ros/map_conversions.h"

#include <cmath>

#include <gtest/gtest.h>

#include "ros/filter_conversions.h"
#include "ros/time_conversions.h"

namespace hymm {
namespace {

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
  ASSERT_EQ(back.merges.size(), 1U);
  EXPECT_EQ(back.merges[0].from_id, 5);
  EXPECT_EQ(back.merges[0].into_id, 3);
  ASSERT_EQ(back.cross_covariances.size(), 1U);
  EXPECT_EQ(back.cross_covariances[0].block, block);
}

TEST(FilterConversions, PoseKeepsPlaceAndCovariance) {
  core::PoseEstimate estimate;
  estimate.time_s = 7.0;
  estimate.T_map_base = {10.0, -20.0, 3.0};
  estimate.covariance << 1.0, 0.1, 0.2, 0.1, 2.0, 0.3, 0.2, 0.3, 3.0;
  estimate.map_version = 9;
  const core::PoseEstimate back = fromMessage(toMessage(estimate, "map"));
  EXPECT_EQ(back.T_map_base.x_m, 10.0);
  EXPECT_EQ(back.T_map_base.y_m, -20.0);
  EXPECT_NEAR(back.T_map_base.yaw_rad, 3.0, 1e-15);
  EXPECT_EQ(back.covariance, estimate.covariance);
  EXPECT_EQ(back.map_version, 9U);
}

TEST(TimeConversions, WhatAStampCannotHoldIsNoStamp) {
  EXPECT_TRUE(toRosTime(-1.0).isZero());
  EXPECT_TRUE(toRosTime(std::nan("")).isZero());
  EXPECT_TRUE(toRosTime(1e12).isZero());
  EXPECT_EQ(toRosTime(1.25), ros::Time(1, 250000000));
}

}  // namespace
}  // namespace hymm
