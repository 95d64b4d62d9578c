#include "evaluation/evaluation_report.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

namespace hymm::core {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const EvaluationOptions kWhole{{-kInfinity, kInfinity}};

RunResults straightRun() {
  RunResults results;
  for (int i = 0; i < 50; ++i) {
    const double t = 0.2 * i;
    results.poses.push_back({{t, {2.0 * t, 0.1 * t * t, 0.0}}, Eigen::Matrix3d::Identity()});
    results.nis.push_back({t, 4.0, 4});
  }
  for (int i = 0; i < 5; ++i) {
    LandmarkEstimate landmark;
    landmark.position = {4.0 * i, 3.0 + 0.5 * i * i};
    results.landmarks.push_back(landmark);
  }
  return results;
}

/// The same run as truth, seen from another frame.
Reference truthSeenFrom(const Pose2& T_world_map) {
  Reference reference;
  for (const UncertainPose& pose : straightRun().poses) {
    reference.poses.push_back({pose.pose.time_s, T_world_map * pose.pose.pose});
  }
  for (const LandmarkEstimate& landmark : straightRun().landmarks) {
    reference.landmarks.push_back(T_world_map * landmark.position);
  }
  reference.in_map_frame = false;
  return reference;
}

TEST(Evaluation, TruthInAFrameOfItsOwnIsMovedToTheMap) {
  const auto report = evaluate(straightRun(), truthSeenFrom({100.0, 50.0, 1.2}), kWhole);
  const YAML::Node json = YAML::Load(report.json.text());
  EXPECT_NEAR(json["trajectory"]["rmse_m"].as<double>(), 0.0, 1e-9);
  EXPECT_NEAR(json["landmarks"]["rmse_m"].as<double>(), 0.0, 1e-9);
  EXPECT_EQ(json["landmarks"]["matched"].as<int>(), 5);
  EXPECT_EQ(json["nis"]["mean_per_dof"].as<double>(), 1.0);
}

TEST(Evaluation, WhatCannotBeComputedIsNullAndTold) {
  const auto report = evaluate(straightRun(), {}, kWhole);
  const YAML::Node json = YAML::Load(report.json.text());
  EXPECT_TRUE(json["trajectory"].IsNull());
  EXPECT_TRUE(json["landmarks"].IsNull());
  EXPECT_TRUE(json["gps"].IsNull());
  EXPECT_THAT(report.remarks, Contains(HasSubstr("no GPS fixes")));
}

TEST(Evaluation, WindowWithoutFixesIsNullAndTold) {
  Reference reference;
  for (int i = 0; i < 9; ++i) reference.fixes.push_back({1.0 * i, {2.0 * i, 0.0}});
  reference.gps_antenna = Eigen::Vector2d(0.0, 0.0);
  const auto report = evaluate(straightRun(), reference, {{600.0, kInfinity}});
  EXPECT_TRUE(YAML::Load(report.json.text())["gps"].IsNull());
  EXPECT_THAT(report.remarks, Contains(HasSubstr("of the window")));
}

TEST(Evaluation, AsksForTheAntennaWhereItIsNotKnown) {
  Reference reference;
  reference.fixes = {{0.0, {0.0, 0.0}}, {1.0, {2.0, 0.0}}, {2.0, {4.0, 0.0}}};
  const auto report = evaluate(straightRun(), reference, kWhole);
  EXPECT_THAT(report.remarks, Contains(HasSubstr("--antenna")));
}

TEST(Evaluation, SaysThatAnEarlierMapIsLeftOut) {
  RunResults results = straightRun();
  results.resets = 2;
  EXPECT_THAT(evaluate(results, {}, kWhole).remarks, Contains(HasSubstr("begun anew 2 times")));
}

TEST(Evaluation, SurveyedLandmarksAreReachedThroughTheGps) {
  const Pose2 T_gps_map{40.0, -30.0, 2.0};
  Reference reference;
  for (const UncertainPose& pose : straightRun().poses) {
    reference.fixes.push_back({pose.pose.time_s, T_gps_map * pose.pose.pose.position()});
  }
  for (const LandmarkEstimate& landmark : straightRun().landmarks) {
    reference.landmarks.push_back(T_gps_map * landmark.position);
  }
  reference.gps_antenna = Eigen::Vector2d(0.0, 0.0);
  reference.landmarks_in_gps_frame = true;
  const auto report = evaluate(straightRun(), reference, kWhole);
  const YAML::Node json = YAML::Load(report.json.text());
  EXPECT_EQ(json["landmarks"]["matched"].as<int>(), 5);
  EXPECT_NEAR(json["landmarks"]["rmse_m"].as<double>(), 0.0, 1e-9);
}

TEST(Evaluation, SurveyInAFrameOfItsOwnIsFoundByItsPattern) {
  RunResults results = straightRun();
  Reference reference;
  reference.landmarks_in_gps_frame = true;
  results.landmarks.clear();
  for (int i = 0; i < 12; ++i) {
    LandmarkEstimate landmark;
    landmark.position = {7.0 * i + 0.3 * i * i, 20.0 * std::sin(2.0 * i)};
    results.landmarks.push_back(landmark);
    reference.landmarks.push_back(Pose2{500.0, -900.0, 2.0} * landmark.position);
  }
  const auto report = evaluate(results, reference, kWhole);
  const YAML::Node json = YAML::Load(report.json.text());
  EXPECT_EQ(json["landmarks"]["matched"].as<int>(), 12);
  EXPECT_NEAR(json["landmarks"]["aligned"]["rmse_m"].as<double>(), 0.0, 1e-9);
}

}  // namespace
}  // namespace hymm::core
