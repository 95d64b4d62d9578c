#include "door_planner/door_planner.h"

#include <cmath>
#include <thread>
#include <vector>

#include <gmock/gmock.h>

#include "common/error.h"
#include "common/random.h"
#include "support/planner_worlds.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;
using test::discs;
using test::freeGround;
using test::isFree;
using test::Occupancy;
using test::requestFor;
using test::wallWithGap;
using World = test::PlannerWorld;

TEST(DoorPlanner, GoesStraightOverFreeGround) {
  const World world(freeGround);
  const Vector2d start(5.0, 6.0), goal(40.0, 33.0);
  const Plan plan = world.plan(start, goal);
  ASSERT_EQ(plan.status, PlanStatus::kOk) << plan.sentence;
  EXPECT_NEAR(plan.cost, (goal - start).norm(), 1e-6);
  EXPECT_EQ(plan.path.size(), 2U);
  EXPECT_GT(plan.doors.size(), 3U);
}

TEST(DoorPlanner, FindsTheGap) {
  const Occupancy wall = wallWithGap(30.0, 4.0);
  const World world(wall);
  const Vector2d start(8.0, 8.0), goal(40.0, 8.0);
  const Plan plan = world.plan(start, goal);
  ASSERT_EQ(plan.status, PlanStatus::kOk) << plan.sentence;
  EXPECT_TRUE(isFree(plan.path, wall));
  // Half the vehicle's width from the corners of the gap, at (24 -+ 0.3, 28).
  const double shortest =
      (Vector2d(23.7, 28.95) - start).norm() + 0.6 + (Vector2d(24.3, 28.95) - goal).norm();
  EXPECT_NEAR(plan.cost, shortest, 0.02 * shortest);
}

TEST(DoorPlanner, TellsOfAVehicleThatIsWiderThanEveryDoor) {
  DoorPlannerConfig config;
  config.vehicle.width_m = 4.5;
  const World world(wallWithGap(30.0, 4.0), config);
  const Plan plan = world.plan({8.0, 8.0}, {40.0, 8.0});
  EXPECT_EQ(plan.status, PlanStatus::kNoPath);
  EXPECT_THAT(plan.sentence, testing::HasSubstr("wide enough"));
}

TEST(DoorPlanner, TellsWhatIsWrongWithStartAndGoal) {
  const World world(wallWithGap(30.0, 4.0));
  EXPECT_EQ(world.plan({24.0, 8.0}, {40.0, 8.0}).status, PlanStatus::kStartOccupied);
  EXPECT_EQ(world.plan({8.0, 8.0}, {24.0, 8.0}).status, PlanStatus::kGoalOccupied);
  EXPECT_EQ(world.plan({8.0, 8.0}, {24.9, 8.0}).status, PlanStatus::kGoalOccupied)
      << "too near to the wall for the vehicle's width";
  EXPECT_EQ(world.plan({-80.0, 8.0}, {40.0, 8.0}).status, PlanStatus::kStartOutsideMap);
  EXPECT_EQ(world.plan({8.0, 8.0}, {40.0, 800.0}).status, PlanStatus::kGoalOutsideMap);
  EXPECT_EQ(world.plan({NAN, 8.0}, {40.0, 8.0}).status, PlanStatus::kBadRequest);
}

TEST(DoorPlanner, TellsOfAGoalOnAnotherIsland) {
  const World world([](const Vector2d& p) { return std::abs(p.x() - 24.0) < 0.3 ? 1.0F : 0.0F; });
  const Plan plan = world.plan({8.0, 8.0}, {40.0, 8.0});
  EXPECT_EQ(plan.status, PlanStatus::kNoPath);
  EXPECT_THAT(plan.sentence, testing::HasSubstr("not connected"));
}

TEST(DoorPlanner, MovesAnOccupiedGoalWithinTheTolerance) {
  const World world(wallWithGap(30.0, 4.0));
  PlanRequest request = requestFor({8.0, 8.0}, {23.9, 8.0});
  request.tolerance_m = 2.0;
  const Plan plan = world.planner.plan(request);
  ASSERT_EQ(plan.status, PlanStatus::kOk) << plan.sentence;
  EXPECT_LE((plan.path.back() - request.goal).norm(), 2.0);
}

TEST(DoorPlanner, RefusesAToleranceThatIsNotFinite) {
  const World world(freeGround);
  PlanRequest request = requestFor({8.0, 8.0}, {40.0, 8.0});
  for (const double tolerance_m : {double{INFINITY}, double{NAN}, -1.0}) {
    request.tolerance_m = tolerance_m;
    EXPECT_EQ(world.planner.plan(request).status, PlanStatus::kBadRequest) << tolerance_m;
  }
}

TEST(DoorPlanner, LooksForAFreePlaceNoFartherThanTheMapReaches) {
  const World world([](const Vector2d&) { return 1.0F; });
  PlanRequest request = requestFor({8.0, 8.0}, {40.0, 8.0});
  request.tolerance_m = 1e6;
  int asked = 0;
  request.interrupted = [&] {
    ++asked;
    return PlanStatus::kOk;
  };
  // The map is 70 m from corner to corner, some hundred steps.
  for (const auto& [start, status] :
       {std::make_pair(Vector2d(8.0, 8.0), PlanStatus::kStartOccupied),
        std::make_pair(Vector2d(-9e5, 8.0), PlanStatus::kStartOutsideMap),
        std::make_pair(Vector2d(1e200, 8.0), PlanStatus::kStartOutsideMap)}) {
    request.start = start;
    asked = 0;
    EXPECT_EQ(world.planner.plan(request).status, status);
    EXPECT_LE(asked, 4);
  }
  request.start = {8.0, 8.0};
  request.interrupted = [] { return PlanStatus::kTimeout; };
  EXPECT_EQ(world.planner.plan(request).status, PlanStatus::kTimeout);
}

TEST(DoorPlanner, FindsAFreePlaceInAMapFarAway) {
  const World world(freeGround);
  PlanRequest request = requestFor({-9e5, 24.0}, {40.0, 8.0});
  request.tolerance_m = 1e6;
  const Plan plan = world.planner.plan(request);
  ASSERT_TRUE(plan.ok()) << plan.sentence;
  EXPECT_LT(plan.path.front().x(), 6.0);
}

TEST(DoorPlanner, AnswersBeforeAnyMapArrived) {
  const DoorPlanner planner{DoorPlannerConfig{}};
  EXPECT_EQ(planner.plan({}).status, PlanStatus::kNoMap);
}

TEST(DoorPlanner, RefusesAnUnusableConfigurationWithAllItsProblems) {
  DoorPlannerConfig config;
  config.vehicle.width_m = -1.0;
  config.cost.properties = "traffic -2";
  try {
    const DoorPlanner planner(config);
    FAIL() << "must be refused";
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.problems().size(), 2U);
  }
}

TEST(DoorPlanner, EndsWhenItIsInterrupted) {
  const World world(freeGround);
  PlanRequest request = requestFor({5.0, 6.0}, {40.0, 33.0});
  request.interrupted = [] { return PlanStatus::kTimeout; };
  EXPECT_EQ(world.planner.plan(request).status, PlanStatus::kTimeout);
  request.interrupted = [] { return PlanStatus::kCancelled; };
  EXPECT_EQ(world.planner.plan(request).status, PlanStatus::kCancelled);
}

TEST(DoorPlanner, StaysWhereItIsInformedOrSaysThatItCannot) {
  const World world(freeGround);
  PlanRequest request = requestFor({5.0, 8.0}, {40.0, 8.0});
  // A stripe across the straight way is not informed, up to y = 20 m.
  request.is_informed = [](const Vector2d& p) {
    return std::abs(p.x() - 22.0) > 4.0 || p.y() > 20.0;
  };
  const Plan around = world.planner.plan(request);
  ASSERT_EQ(around.status, PlanStatus::kOk) << around.sentence;
  // Asked every quarter of a metre, so that corners may be cut by half of that.
  EXPECT_TRUE(isFree(around.path, [](const Vector2d& p) {
    return std::abs(p.x() - 22.0) < 3.875 && p.y() < 19.875 ? 1.0F : 0.0F;
  }));
  request.is_informed = [](const Vector2d& p) { return std::abs(p.x() - 22.0) > 4.0; };
  EXPECT_EQ(world.planner.plan(request).status, PlanStatus::kBelowInformation);
  request.is_informed = [](const Vector2d& p) { return p.x() > 10.0; };
  EXPECT_EQ(world.planner.plan(request).status, PlanStatus::kBelowInformation);
}

TEST(DoorPlanner, AsksForNoOtherWayWhenItsTimeIsOver) {
  const World world(freeGround);
  PlanRequest request = requestFor({5.0, 8.0}, {40.0, 8.0});
  request.is_informed = [](const Vector2d& p) { return std::abs(p.x() - 22.0) > 4.0; };
  // When it is asked again there was no way that is informed.
  int asked = 0;
  request.interrupted = [&] { return ++asked > 1 ? PlanStatus::kTimeout : PlanStatus::kOk; };
  EXPECT_EQ(world.planner.plan(request).status, PlanStatus::kTimeout);
}

TEST(DoorPlanner, KeepsHalfTheWidthAwayFromObstaclesAcrossSides) {
  // A disc in the middle of a side, seen in one LTR only.
  test::SquareMesh mesh(1, 1, 16.0, 0.2);
  DoorPlanner planner{DoorPlannerConfig{}};
  planner.setLtrs(mesh.ltrs);
  const Occupancy disc = [](const Vector2d& p) {
    return (p - Vector2d(7.6, 7.6)).norm() < 0.4 ? 1.0F : 0.0F;
  };
  planner.setContent(0, test::contentOf(mesh.ltrs[0], disc));
  planner.setContent(1, test::contentOf(mesh.ltrs[1], freeGround));
  planner.prepare(Vector2d::Zero());
  PlanRequest request = requestFor({8.4, 8.4}, {14.0, 14.0});  // both in the other LTR
  EXPECT_EQ(planner.plan(request).status, PlanStatus::kStartOccupied);
  request.start = {9.3, 9.3};
  EXPECT_EQ(planner.plan(request).status, PlanStatus::kOk);
}

TEST(DoorPlanner, FollowsTheLandmarksWithoutPlanning) {
  World world(freeGround);
  const Plan plan = world.plan({5.0, 6.0}, {40.0, 33.0});
  const Pose2 moved{3.0, 1.0, 0.4};
  const auto places = placeOf(plan.points, [&](int landmark) -> std::optional<Vector2d> {
    return moved * world.mesh.landmarks[std::size_t(landmark)];
  });
  ASSERT_TRUE(places);
  for (std::size_t i = 0; i < plan.path.size(); ++i) {
    EXPECT_TRUE((*places)[i].isApprox(moved * plan.path[i], 1e-9));
  }
  EXPECT_FALSE(placeOf(plan.points, [](int) { return std::optional<Vector2d>(); }));
}

TEST(DoorPlanner, TellsWhereAPathIsBlockedNow) {
  World world(freeGround);
  const Plan plan = world.plan({8.0, 8.0}, {40.0, 8.0});
  EXPECT_FALSE(world.planner.findBlocked(plan.path));
  world.show(wallWithGap(30.0, 4.0));
  EXPECT_EQ(world.planner.findBlocked(plan.path), std::optional<std::size_t>(1));
  const Plan again = world.plan({8.0, 8.0}, {40.0, 8.0});
  ASSERT_EQ(again.status, PlanStatus::kOk);
  EXPECT_FALSE(world.planner.findBlocked(again.path));
}

TEST(DoorPlanner, CrossesNothingOccupiedInRandomWorlds) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Vector2d start(6.0, 6.0), goal(42.0, 42.0);
    const Occupancy occupancy = discs(seed, 40, 48.0, {start, goal});
    const World world(occupancy);
    const Plan plan = world.plan(start, goal);
    if (!plan.ok()) continue;
    EXPECT_TRUE(isFree(plan.path, occupancy)) << "seed " << seed;
    EXPECT_FALSE(world.planner.findBlocked(plan.path)) << "seed " << seed;
  }
}

TEST(DoorPlanner, AnswersManyRequestsAtOnceAsOneByOne) {
  const Occupancy occupancy = discs(7, 30, 48.0, {});
  World world(occupancy);
  RandomGenerator generator(1);
  std::vector<PlanRequest> requests(100);
  for (PlanRequest& request : requests) {
    request.start = {sampleUniform(generator, 0.0, 48.0), sampleUniform(generator, 0.0, 48.0)};
    request.goal = {sampleUniform(generator, 0.0, 48.0), sampleUniform(generator, 0.0, 48.0)};
  }
  std::vector<Plan> alone, together(requests.size());
  for (const PlanRequest& request : requests) alone.push_back(world.planner.plan(request));
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 8; ++t) {
    threads.emplace_back([&, t] {
      for (std::size_t i = t; i < requests.size(); i += 8)
        together[i] = world.planner.plan(requests[i]);
    });
  }
  for (int i = 0; i < 5; ++i) world.planner.prepare(Vector2d::Zero());
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < requests.size(); ++i) {
    EXPECT_EQ(together[i].status, alone[i].status);
    EXPECT_EQ(together[i].cost, alone[i].cost);
    EXPECT_EQ(together[i].path.size(), alone[i].path.size());
  }
}

}  // namespace
}  // namespace hymm::core
