#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "door_planner/door_planner.h"
#include "support/planner_worlds.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;
using test::freeGround;

/// The distance of a path from a place.
double distance_m(const std::vector<Vector2d>& path, const Vector2d& place) {
  double least = (path.front() - place).norm();
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Vector2d along = path[i] - path[i - 1];
    const double at = std::clamp(
        (place - path[i - 1]).dot(along) / std::max(along.squaredNorm(), 1e-12), 0.0, 1.0);
    least = std::min(least, (path[i - 1] + at * along - place).norm());
  }
  return least;
}

/// Two squares of free ground of 16 m beside each other, as LTRs.
struct TwoSquares {
  test::SquareMesh mesh{2, 1, 16.0, 0.2};
  DoorPlanner planner;

  explicit TwoSquares(bool outside_is_occupied) : planner(configOf(outside_is_occupied)) {
    planner.setLtrs(mesh.ltrs);
    for (const LtrView& ltr : mesh.ltrs) {
      planner.setContent(ltr.id, test::contentOf(ltr, freeGround));
    }
    planner.prepare(Vector2d::Zero());
  }
  static DoorPlannerConfig configOf(bool outside_is_occupied) {
    DoorPlannerConfig config;
    config.vehicle.width_m = 1.6;
    config.outside_is_occupied = outside_is_occupied;
    return config;
  }
  void setLandmarks(std::vector<SolidLandmark> added, double diameter_m) {
    for (std::size_t id = 0; id < mesh.landmarks.size(); ++id) {
      added.push_back({static_cast<int>(id), mesh.landmarks[id], diameter_m});
    }
    planner.setLandmarks(added);
    planner.prepare(Vector2d::Zero());
  }
  Plan plan(const Vector2d& start, const Vector2d& goal) const {
    return planner.plan(test::requestFor(start, goal));
  }
};

TEST(DoorPlanner, PassesTreesAtTheBorderOfTheLtrs) {
  TwoSquares world(false);
  const Vector2d tree = world.mesh.landmarks[1], start(12.0, 0.3), goal(20.0, 0.3);
  ASSERT_LT(distance_m(world.plan(start, goal).path, tree), 0.4) << "nothing is known of the tree";
  world.setLandmarks({}, 0.7);
  const Plan plan = world.plan(start, goal);
  ASSERT_EQ(plan.status, PlanStatus::kOk) << plan.sentence;
  EXPECT_GE(distance_m(plan.path, tree), 0.35 + 0.8);
  EXPECT_LT(distance_m(plan.path, tree), 0.35 + 0.8 + 0.6) << "not further than needed";
}

TEST(DoorPlanner, PassesLandmarksThatNoCellShows) {
  TwoSquares world(true);
  const Vector2d start(4.0, 8.0), goal(28.0, 8.0);
  for (const Vector2d& post : {Vector2d(12.0, 8.0), Vector2d(16.0, 8.2)}) {
    world.setLandmarks({{100, post, 0.4}}, 0.0);
    const Plan plan = world.plan(start, goal);
    ASSERT_EQ(plan.status, PlanStatus::kOk) << plan.sentence;
    EXPECT_GE(distance_m(plan.path, post), 0.2 + 0.8);
  }
  world.setLandmarks({{100, Vector2d(12.0, 8.0), std::nan("")}}, 0.0);
  EXPECT_GE(distance_m(world.plan(start, goal).path, Vector2d(12.0, 8.0)), 0.25 + 0.8)
      << "by landmark_diameter_m";
  world.setLandmarks({}, 0.0);
  EXPECT_NEAR(world.plan(start, goal).length_m, 24.0, 1e-6) << "it is no more";
}

TEST(DoorPlanner, StaysWithinTheLtrsUnlessItIsToldThatOutsideIsFree) {
  const Vector2d start(4.0, 2.0), goal(28.0, 0.3);
  EXPECT_EQ(TwoSquares(false).plan(start, goal).status, PlanStatus::kOk);
  const TwoSquares world(true);
  EXPECT_EQ(world.plan(start, goal).status, PlanStatus::kGoalOccupied);
  for (const Vector2d& point : world.plan(start, {28.0, 2.0}).path) EXPECT_GE(point.y(), 0.8);
}

TEST(DoorPlanner, FindsBlockedCellsAnewOnlyWhereLandmarksMoveRelativeToLtrs) {
  TwoSquares world(true);
  const Vector2d post(9.0, 9.0);
  world.setLandmarks({{100, post, 0.4}}, 0.5);
  const std::size_t blocked = world.planner.counts().blocked;
  const Pose2 moved{30.0, -10.0, 0.7};
  test::Landmarks landmarks;
  for (const Vector2d& landmark : world.mesh.landmarks) landmarks.push_back(moved * landmark);
  world.mesh.moveTo(landmarks);
  world.planner.setLtrs(world.mesh.ltrs);
  world.setLandmarks({{100, moved * post, 0.4}}, 0.5);
  EXPECT_EQ(world.planner.counts().blocked, blocked) << "all moved together";
  world.setLandmarks({{100, moved * (post + Vector2d(0.04, 0.0)), 0.4}}, 0.5);
  EXPECT_EQ(world.planner.counts().blocked, blocked) << "within what is kept away in addition";
  world.setLandmarks({{100, moved * (post + Vector2d(0.5, 0.0)), 0.4}}, 0.5);
  EXPECT_GT(world.planner.counts().blocked, blocked);
  const Plan plan = world.plan(moved * Vector2d(4.0, 9.0), moved * Vector2d(14.0, 9.0));
  EXPECT_GE(distance_m(plan.path, moved * (post + Vector2d(0.5, 0.0))), 0.2 + 0.8);
}

TEST(DoorPlanner, PlansBesideLandmarksOfSenselessSizeAndPlace) {
  TwoSquares world(true);
  const PlanStatus status = world.plan({4.0, 9.0}, {14.0, 9.0}).status;
  std::vector<SolidLandmark> landmarks;
  for (const double senseless : {1e10, 1e300}) {
    landmarks.push_back({int(landmarks.size()) + 100, Vector2d(1e6, 1e6), senseless});
    landmarks.push_back({int(landmarks.size()) + 100, Vector2d(senseless, 0.0), 0.4});
  }
  world.planner.setLandmarks(landmarks);
  world.planner.prepare(Vector2d::Zero());
  EXPECT_EQ(world.plan({4.0, 9.0}, {14.0, 9.0}).status, status);
}

}  // namespace
}  // namespace hymm::core
