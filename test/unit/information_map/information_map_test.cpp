#include "information_map/information_map.h"

#include <cmath>

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "dense_images.h"
#include "random_landmarks.h"
#include "simulation/simulation_config.h"
#include "support/numeric_jacobian.h"

namespace hymm::core {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// Two rows of trunks along a straight way from x = 0 to `length_m`, 6 m to either side.
LandmarkMap alley(double length_m, double shift_m = 0.0, std::uint64_t version = 1) {
  std::vector<Vector2d> places;
  for (double x = 0.0; x <= length_m; x += 5.0) {
    places.emplace_back(x, 6.0 + shift_m);
    places.emplace_back(x, -6.0 + shift_m);
  }
  const auto n = Eigen::Index(2 * places.size());
  return mapOf(places, 4e-4 * Eigen::MatrixXd::Identity(n, n), version);
}

InformationMap alleyMap(const InformationMapConfig& config = {}) {
  InformationMap information(config, simulatedCar());
  EXPECT_THAT(information.apply(alley(60.0), Pose2{}).refused, IsEmpty());
  return information;
}

ExplorationRequest fromTheStart() {
  ExplorationRequest request;
  request.covariance = Eigen::Vector3d(0.01, 0.01, 1e-4).asDiagonal();
  return request;
}

TEST(InformationMap, RefusesAnOlderMap) {
  InformationMap information({}, simulatedCar());
  information.apply(alley(60.0, 0.0, 7), Pose2{});
  const LevelSetUpdate update = information.apply(alley(30.0, 0.0, 6), Pose2{});
  EXPECT_THAT(update.refused, HasSubstr("version 6 is older than 7"));
  EXPECT_EQ(information.mapVersion(), 7U);
  EXPECT_EQ(information.counts().refused_maps, 1U);
  information.reset();
  EXPECT_THAT(information.apply(alley(30.0, 0.0, 6), Pose2{}).refused, IsEmpty());
}

TEST(InformationMap, TellsTheVehiclesIsland) {
  const LevelSets sets = alleyMap().levelSets();
  ASSERT_THAT(sets.sets, SizeIs(2));
  EXPECT_EQ(sets.map_version, 1U);
  ASSERT_THAT(sets.sets[0].islands, SizeIs(1));
  EXPECT_EQ(sets.sets[0].vehicle_island, sets.sets[0].islands[0].id);
  double area_m2 = 0.0;
  for (const LevelLeaf& leaf : sets.sets[0].leaves) area_m2 += leaf.edge_m * leaf.edge_m;
  EXPECT_DOUBLE_EQ(area_m2, sets.sets[0].area_m2);
}

TEST(InformationMap, MovesItsSetsWithTheLandmarks) {
  const InformationMap information = alleyMap();
  const LevelSets here = information.levelSets();
  const LevelSets moved = information.levelSetsMovedTo(alley(60.0, 2.5, 2));
  EXPECT_EQ(moved.map_version, 2U);
  EXPECT_EQ(moved.computed_version, 1U);
  ASSERT_EQ(moved.sets[0].leaves.size(), here.sets[0].leaves.size());
  for (std::size_t i = 0; i < here.sets[0].leaves.size(); ++i) {
    const Vector2d motion = moved.sets[0].leaves[i].centre - here.sets[0].leaves[i].centre;
    EXPECT_NEAR((motion - Vector2d(0.0, 2.5)).norm(), 0.0, 1e-9);
  }
}

TEST(InformationMap, TellsInformationOnBaseLink) {
  const VehicleConfig vehicle = simulatedCar();
  const InformationMap information = alleyMap();
  const Pose2 T_map_base{20.0, 1.0, 0.4};
  InformationEvaluator evaluator(InformationConfig{});
  const Matrix3d on_sensor =
      evaluator.at(LandmarkField(alley(60.0), 15.0), T_map_base * vehicle.laser.T_base_sensor())
          .matrix;
  const Matrix3d J = test::numericJacobian(
      [&](const Eigen::Vector3d& pose) {
        return (Pose2::fromVector(pose) * vehicle.laser.T_base_sensor()).vector();
      },
      T_map_base.vector());
  EXPECT_TRUE(
      information.evaluate(T_map_base).matrix.isApprox(J.transpose() * on_sensor * J, 1e-6));
}

TEST(ExplorationPlanner, SuggestsTheFarEndOfAnAlley) {
  InformationMapConfig config;
  config.exploration.max_suggestions = 100;
  const InformationMap information = alleyMap(config);
  const ExplorationAnswer answer = information.suggestExploration(fromTheStart());
  EXPECT_THAT(answer.problem, IsEmpty());
  ASSERT_THAT(answer.goals, testing::Not(IsEmpty()));
  bool reaches_the_end = false;
  for (const ExplorationGoal& goal : answer.goals) {
    EXPECT_LE(goal.position_deviation_m, 0.5);
    EXPECT_LE(goal.heading_deviation_rad, 0.05);
    EXPECT_GT(goal.new_area_m2, 0.0);
    for (std::size_t i = 1; i < goal.way.size(); ++i) {
      EXPECT_GT(information.search().lattice().levelAt(goal.way[i]), 0);
    }
    reaches_the_end = reaches_the_end || goal.T_map_base.x_m > 60.0;
  }
  EXPECT_TRUE(reaches_the_end);
}

TEST(ExplorationPlanner, LeavesOutWhatIsReachedWithTooLargeDeviations) {
  InformationMapConfig config;
  config.exploration.max_position_deviation_m = 0.01;
  const ExplorationAnswer answer = alleyMap(config).suggestExploration(fromTheStart());
  EXPECT_THAT(answer.goals, IsEmpty());
  EXPECT_GT(answer.candidates, 10);
  EXPECT_THAT(answer.problem, HasSubstr("none can be reached with the deviations"));
}

TEST(ExplorationPlanner, CountsTheIslandThatAGoalReaches) {
  LandmarkMap map = alley(60.0);
  const LandmarkMap far = alley(20.0);
  for (LandmarkEstimate landmark : far.landmarks) {
    landmark.id += 1000;
    landmark.position.x() += 90.0;
    map.landmarks.push_back(landmark);
  }
  for (CrossCovariance pair : far.cross_covariances) {
    pair.first_id += 1000;
    pair.second_id += 1000;
    map.cross_covariances.push_back(pair);
  }
  InformationMap information({}, simulatedCar());
  information.apply(map, Pose2{});
  ASSERT_THAT(information.search().islands(1).islands(), SizeIs(2));
  const int far_island =
      information.search().islands(1).islandOf(information.search().lattice(), {100, 0});
  const ExplorationAnswer answer = information.suggestExploration(fromTheStart());
  ASSERT_THAT(answer.goals, testing::Not(IsEmpty()));
  EXPECT_EQ(answer.goals.front().joins_island, far_island);
}

TEST(ExplorationPlanner, GoesAroundWhatIsOccupied) {
  InformationMap information = alleyMap();
  OccupancyImage image = freeImage(-20.0, -20.0, 80.0, 20.0);
  fillBox(image, 30.0, -20.0, 30.4, 19.9);  // across the whole alley
  information.setDenseMap(image);
  const ExplorationAnswer blocked = information.suggestExploration(fromTheStart());
  EXPECT_THAT(blocked.goals, testing::Not(IsEmpty()));
  for (const ExplorationGoal& goal : blocked.goals) {
    EXPECT_LT(goal.T_map_base.x_m, 30.0 - 0.5 * simulatedCar().width_m);
  }
  fillBox(image, 30.0, -2.0, 30.4, 2.0);
  for (int y = 0; y < image.height; ++y) {
    if (std::abs(image.centre(0, y).y()) > 2.0) continue;  // a gate of 4 m
    for (int x = 0; x < image.width; ++x) image.cells[image.index(x, y)] = 0;
  }
  information.setDenseMap(image);
  bool passes = false;
  for (const ExplorationGoal& goal : information.suggestExploration(fromTheStart()).goals) {
    passes = passes || goal.T_map_base.x_m > 31.0;
    for (const Vector2d& place : goal.way) {
      if (std::abs(place.x() - 30.2) > 0.5) continue;
      EXPECT_LT(std::abs(place.y()), 2.0);
    }
  }
  EXPECT_TRUE(passes);
}

TEST(ExplorationPlanner, SaysThatNothingCanBeReached) {
  InformationMapConfig config;
  config.dense_map.unknown_is_free = false;
  InformationMap information(config, simulatedCar());
  information.apply(alley(60.0), Pose2{});
  information.setDenseMap(unknownImage(-20.0, -20.0, 80.0, 20.0));
  EXPECT_THAT(information.suggestExploration(fromTheStart()).problem,
              HasSubstr("No place at the border can be reached"));
}

TEST(InformationMap, HidesLandmarksBehindTheDenseMapIfAsked) {
  OccupancyImage image = freeImage(-20.0, -20.0, 80.0, 20.0);
  fillBox(image, -20.0, 3.0, 79.9, 3.4);  // a wall before one of the rows
  const Vector2d place(30.0, 0.0);
  for (const bool occlusion : {false, true}) {
    InformationMapConfig config;
    config.dense_map.occlusion = occlusion;
    InformationMap information = alleyMap(config);
    const int all = information.evaluatePlace(place).landmarks;
    const double area_m2 = information.levelSets().sets[1].area_m2;
    information.setDenseMap(image);
    information.apply(alley(60.0, 0.0, 2), Pose2{});
    EXPECT_EQ(information.evaluatePlace(place).landmarks, occlusion ? all / 2 : all);
    EXPECT_EQ(information.levelSets().sets[1].area_m2 < area_m2, occlusion);
    information.reset();  // without a dense map again
    information.apply(alley(60.0, 0.0, 3), Pose2{});
    EXPECT_EQ(information.evaluatePlace(place).landmarks, all);
    EXPECT_DOUBLE_EQ(information.levelSets().sets[1].area_m2, area_m2);
  }
}

TEST(ExplorationPlanner, SaysWhenTheVehicleIsOutside) {
  ExplorationRequest request = fromTheStart();
  request.T_map_base = {500.0, 0.0, 0.0};
  EXPECT_THAT(alleyMap().suggestExploration(request).problem,
              HasSubstr("neither in the level set nor within"));
  request.level = 0;
  EXPECT_THAT(alleyMap().suggestExploration(request).problem, HasSubstr("the lowest is 25"));
}

TEST(ExplorationPlanner, HasNothingToSuggestWithoutLandmarks) {
  const InformationMap information({}, simulatedCar());
  EXPECT_THAT(information.suggestExploration(fromTheStart()).problem,
              HasSubstr("neither in the level set nor within"));
}

}  // namespace
}  // namespace hymm::core
