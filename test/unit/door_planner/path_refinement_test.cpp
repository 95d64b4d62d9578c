#include "door_planner/path_refinement.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/car_paths.h"
#include "support/planner_worlds.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;
using test::PlannerWorld;

constexpr double kRadius_m = 5.0;

Pose2 randomPose(RandomGenerator& generator) {
  return {sampleUniform(generator, -20.0, 20.0), sampleUniform(generator, -20.0, 20.0),
          sampleUniform(generator, -M_PI, M_PI)};
}

TEST(CarSpace, ReachesItsGoalByPiecesOfTheCurvatureAllowed) {
  RandomGenerator generator(1);
  for (const bool can_reverse : {true, false}) {
    const CarSpace space(kRadius_m, can_reverse);
    for (int i = 0; i < 1000; ++i) {
      const Pose2 from = randomPose(generator), to = randomPose(generator);
      const CarCurve curve = space.shortest(from, to);
      EXPECT_GE(curve.length(), (to.position() - from.position()).norm() - 1e-9);
      Pose2 end = from;
      for (const CurvePiece& piece : curve.pieces) {
        end = advance(end, piece);
        EXPECT_LE(std::abs(piece.curvature), 1.0 / kRadius_m + 1e-12);
        EXPECT_TRUE(can_reverse || piece.length_m > 0.0);
      }
      EXPECT_LT((end.position() - to.position()).norm(), 1e-4);
      EXPECT_NEAR(wrapAngle(end.yaw_rad - to.yaw_rad), 0.0, 1e-5);
    }
  }
}

TEST(CarSpace, NeedsNoMoveToStayWhereItIs) {
  const Pose2 here{1.0, 2.0, 0.5};
  EXPECT_TRUE(CarSpace(kRadius_m, true).shortest(here, here).pieces.empty());
}

TEST(CarSpace, FindsAWayRoundAWallAndTheSameOneAgain) {
  const CarSpace space(kRadius_m, true);
  CarSpace::Maze maze;
  maze.low = {-5.0, -20.0};
  maze.high = {35.0, 20.0};
  maze.is_free = [](const Pose2& pose) {
    return std::abs(pose.x_m - 15.0) > 1.0 || pose.y_m > 8.0;
  };
  maze.sample = [](RandomGenerator& generator) {
    return Pose2{sampleUniform(generator, -5.0, 35.0), sampleUniform(generator, -20.0, 20.0),
                 sampleUniform(generator, -M_PI, M_PI)};
  };
  const Pose2 from{0.0, 0.0, 0.0}, to{30.0, 0.0, 0.0};
  const auto way = space.search(from, {to}, maze, {300, 3, {}});
  ASSERT_TRUE(way);
  for (std::size_t i = 1; i < way->size(); ++i) {
    for (const CarPose& pose : space.shortest((*way)[i - 1], (*way)[i]).poses(0.05)) {
      EXPECT_TRUE(std::abs(pose.T_map_base.x_m - 15.0) > 0.8 || pose.T_map_base.y_m > 7.8);
    }
  }
  space.search(to, {from}, maze, {100, 7, {}});  // OMPL's global sequence moves on
  const auto again = space.search(from, {to}, maze, {300, 3, {}});
  ASSERT_TRUE(again);
  ASSERT_EQ(again->size(), way->size());
  for (std::size_t i = 0; i < way->size(); ++i) {
    EXPECT_EQ((*again)[i].vector(), (*way)[i].vector());
  }
}

TEST(CarSpace, SaysThatThereIsNoWay) {
  CarSpace::Maze maze;
  maze.low = {-5.0, -5.0};
  maze.high = {35.0, 5.0};
  maze.is_free = [](const Pose2& pose) { return std::abs(pose.x_m - 15.0) > 1.0; };
  maze.sample = [](RandomGenerator& generator) {
    return Pose2{sampleUniform(generator, -5.0, 35.0), sampleUniform(generator, -5.0, 5.0), 0.0};
  };
  EXPECT_FALSE(CarSpace(kRadius_m, true).search({}, {{30.0, 0.0, 0.0}}, maze, {300, 1, {}}));
}

TEST(Footprint, CoversTheLengthOfTheVehicle) {
  PlannedVehicleConfig vehicle;
  vehicle.width_m = 2.0;
  vehicle.length_m = 5.0;
  vehicle.rear_overhang_m = 1.0;
  const Footprint footprint(vehicle);
  EXPECT_DOUBLE_EQ(footprint.centres().front(), 0.0);
  EXPECT_DOUBLE_EQ(footprint.centres().back(), 3.0);
  for (std::size_t i = 1; i < footprint.centres().size(); ++i) {
    EXPECT_LE(footprint.centres()[i] - footprint.centres()[i - 1], 1.0 + 1e-12);
  }
}

PlanRequest refinedRequest(const Vector2d& start, const Vector2d& goal) {
  PlanRequest request = test::requestFor(start, goal);
  request.is_refined = true;
  return request;
}

TEST(PathRefinement, RespectsTheTurningRadiusAndTouchesNothingInRandomWorlds) {
  int refined = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    DoorPlannerConfig config;
    config.vehicle.can_reverse = seed % 2 == 0;
    const Vector2d start(8.0, 8.0), goal(40.0, 40.0);
    const PlannerWorld world(test::discs(seed, 30, 48.0, {start, goal}), config);
    const Plan plan = world.planner.plan(refinedRequest(start, goal));
    if (!plan.is_refined) continue;
    ++refined;
    EXPECT_GT(tightestRadius_m(plan), kRadius_m * (1.0 - 1e-3)) << "seed " << seed;
    EXPECT_LE(test::longestStep_m(plan), config.refinement.step_m + 1e-9);
    EXPECT_EQ(test::touches(plan, *world.planner.graph(), config.vehicle), 0) << "seed " << seed;
    EXPECT_TRUE(config.vehicle.can_reverse || !test::goesBackwards(plan));
    EXPECT_FALSE(world.planner.findBlocked(plan.path)) << "seed " << seed;
    EXPECT_NEAR(plan.length_m, plan.cost, 0.1 * plan.cost);
  }
  EXPECT_GE(refined, 8);
}

TEST(PathRefinement, StartsAndEndsWithTheHeadingsThatAreAskedFor) {
  const PlannerWorld world(test::freeGround);
  PlanRequest request = refinedRequest({10.0, 10.0}, {36.0, 36.0});
  request.start_heading = -0.5 * M_PI;
  request.goal_heading = M_PI;
  const Plan plan = world.planner.plan(request);
  ASSERT_TRUE(plan.is_refined) << plan.sentence;
  const auto headingAt = [&](std::size_t i) {
    const Vector2d along = plan.path[i + 1] - plan.path[i];
    const double heading = std::atan2(along.y(), along.x());
    return plan.points[i + 1].is_backwards ? wrapAngle(heading + M_PI) : heading;
  };
  // Half a step is a turn of 0.025 rad at the smallest radius.
  EXPECT_NEAR(wrapAngle(headingAt(0) - *request.start_heading), 0.0, 0.03);
  EXPECT_NEAR(wrapAngle(headingAt(plan.path.size() - 2) - *request.goal_heading), 0.0, 0.03);
  EXPECT_EQ(plan.path.front(), request.start);
  EXPECT_NEAR((plan.path.back() - request.goal).norm(), 0.0, 1e-4);
}

TEST(PathRefinement, FindsTheSamePathAgain) {
  const Vector2d start(8.0, 8.0), goal(40.0, 40.0);
  const PlannerWorld world(test::discs(5, 30, 48.0, {start, goal}));
  const Plan plan = world.planner.plan(refinedRequest(start, goal));
  const Plan again = world.planner.plan(refinedRequest(start, goal));
  EXPECT_EQ(plan.path, again.path);
  EXPECT_EQ(plan.sentence, again.sentence);
}

/// A wall right in front of a car that stands at (10, 20) m and looks along x.
float wallAhead(const Vector2d& p) {
  return p.x() > 14.5 && p.x() < 15.1 && std::abs(p.y() - 20.0) < 9.0 ? 1.0F : 0.0F;
}

TEST(PathRefinement, SearchesAndGivesUpWhereNoCarCanGo) {
  DoorPlannerConfig config;
  config.vehicle.can_reverse = false;
  config.refinement.iterations = 400;
  const PlannerWorld world(wallAhead, config);
  PlanRequest request = refinedRequest({10.0, 20.0}, {30.0, 20.0});
  request.start_heading = 0.0;
  const Plan plan = world.planner.plan(request);
  EXPECT_TRUE(plan.ok());
  EXPECT_FALSE(plan.is_refined);
  EXPECT_THAT(plan.sentence, testing::HasSubstr("no way for its turning radius"));
  // Forwards and backwards, there is one.
  const PlannerWorld reversing(wallAhead);
  const Plan backed = reversing.planner.plan(request);
  ASSERT_TRUE(backed.is_refined) << backed.sentence;
  EXPECT_TRUE(test::goesBackwards(backed));
}

TEST(PathRefinement, LeavesThePathAsItIsAndSaysWhy) {
  // A lane that the disc can follow, but in which no car can stand across.
  const auto lane = [](const Vector2d& p) { return std::abs(p.y() - 20.0) > 1.6 ? 1.0F : 0.0F; };
  const PlannerWorld world(lane);
  PlanRequest request = refinedRequest({8.0, 20.0}, {40.0, 20.0});
  const Plan along = world.planner.plan(request);
  EXPECT_TRUE(along.is_refined) << along.sentence;
  request.goal_heading = 0.5 * M_PI;
  const Plan across = world.planner.plan(request);
  EXPECT_TRUE(across.ok());
  EXPECT_FALSE(across.is_refined);
  EXPECT_THAT(across.sentence, testing::HasSubstr("not refined"));
  EXPECT_THAT(across.sentence, testing::HasSubstr("does not fit at the goal"));
}

/// A way from pose to pose by shortest curves.
std::vector<CarPose> wayBy(const std::vector<Pose2>& poses, const RefinementConfig& config) {
  std::vector<CarPose> way{{poses.front(), false}};
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const CarSpace space(kRadius_m, true);
    const auto curve = space.shortest(poses[i - 1], poses[i]).poses(config.step_m);
    way.insert(way.end(), curve.begin(), curve.end());
  }
  return way;
}

Plan planOf(const std::vector<CarPose>& way) {
  Plan plan;
  for (const CarPose& pose : way) {
    plan.path.push_back(pose.T_map_base.position());
    plan.points.emplace_back();
    plan.points.back().is_backwards = pose.is_backwards;
    if (plan.path.size() == 1) continue;
    plan.length_m += (plan.path.back() - plan.path[plan.path.size() - 2]).norm();
  }
  return plan;
}

TEST(PathRefinement, ShortensDetours) {
  const DoorPlannerConfig config;
  const Vector2d post(22.0, 10.0);
  const auto ground = [&](const Vector2d& p) { return (p - post).norm() < 1.0 ? 1.0F : 0.0F; };
  const PlannerWorld world(ground, config);
  const std::shared_ptr<const DoorGraph> graph = world.planner.graph();
  const PathRefinement refinement(*graph, config.vehicle, config.refinement);
  // A loop, and on it a change of direction that nothing asks for.
  std::vector<CarPose> way = wayBy({{8.0, 10.0, 0.0},
                                    {14.0, 30.0, 1.5},
                                    {20.0, 26.0, 0.0},
                                    {30.0, 30.0, -1.5},
                                    {38.0, 10.0, 0.0}},
                                   config.refinement);
  const Plan before = planOf(way);
  const CarPose start = way.front(), goal = way.back();
  refinement.shorten(way, {});
  const Plan after = planOf(way);
  EXPECT_GT(before.length_m, 60.0);
  EXPECT_LT(after.length_m, 34.0) << "of 30 m straight on";
  EXPECT_FALSE(test::goesBackwards(after));
  EXPECT_EQ(way.front().T_map_base.vector(), start.T_map_base.vector());
  EXPECT_EQ(way.back().T_map_base.vector(), goal.T_map_base.vector());
  EXPECT_GT(tightestRadius_m(after), kRadius_m * (1.0 - 1e-3));
  EXPECT_EQ(test::touches(after, *graph, config.vehicle), 0);
}

TEST(PathRefinement, EndsWhenItsTimeIsOver) {
  const PlannerWorld world(test::freeGround);
  PlanRequest request = refinedRequest({8.0, 8.0}, {40.0, 40.0});
  int asked = 0;
  // The search for a route asks once before it starts; then refinement asks.
  request.interrupted = [&] { return ++asked > 1 ? PlanStatus::kTimeout : PlanStatus::kOk; };
  const Plan plan = world.planner.plan(request);
  EXPECT_TRUE(plan.ok()) << plan.sentence;
  EXPECT_FALSE(plan.is_refined);
  EXPECT_THAT(plan.sentence, testing::HasSubstr("time"));
  asked = 0;
  request.interrupted = [&] { return ++asked > 1 ? PlanStatus::kCancelled : PlanStatus::kOk; };
  EXPECT_EQ(world.planner.plan(request).status, PlanStatus::kCancelled);
}

}  // namespace
}  // namespace hymm::core
