#include "door_planner/door_planner.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <queue>
#include <thread>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
  PlanRequest request;
  request.start = {8.0, 8.0};
  request.goal = {23.9, 8.0};
  request.tolerance_m = 2.0;
  const Plan plan = world.planner.plan(request);
  ASSERT_EQ(plan.status, PlanStatus::kOk) << plan.sentence;
  EXPECT_LE((plan.path.back() - request.goal).norm(), 2.0);
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
  PlanRequest request;
  request.start = {5.0, 6.0};
  request.goal = {40.0, 33.0};
  request.interrupted = [] { return PlanStatus::kTimeout; };
  EXPECT_EQ(world.planner.plan(request).status, PlanStatus::kTimeout);
  request.interrupted = [] { return PlanStatus::kCancelled; };
  EXPECT_EQ(world.planner.plan(request).status, PlanStatus::kCancelled);
}

TEST(DoorPlanner, StaysWhereItIsInformedOrSaysThatItCannot) {
  const World world(freeGround);
  PlanRequest request;
  request.start = {5.0, 8.0};
  request.goal = {40.0, 8.0};
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
  PlanRequest request;
  request.start = {8.4, 8.4};  // in the other LTR
  request.goal = {14.0, 14.0};
  EXPECT_EQ(planner.plan(request).status, PlanStatus::kStartOccupied);
  request.start = {9.3, 9.3};
  EXPECT_EQ(planner.plan(request).status, PlanStatus::kOk);
}

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
    PlanRequest request;
    request.start = start;
    request.goal = goal;
    return planner.plan(request);
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

TEST(DoorPlanner, LeavesOutLtrsOfMoreCellsThanMemoryHas) {
  TwoSquares world(true);
  std::vector<LtrView> ltrs = world.mesh.ltrs;
  ltrs[0].alpha_cells = ltrs[0].beta_cells = std::numeric_limits<int>::max();
  EXPECT_EQ(world.planner.setLtrs(ltrs), std::vector<int>{ltrs[0].id});
  EXPECT_TRUE(world.planner.setLtrs(world.mesh.ltrs).empty());
}

TEST(DoorPlanner, LeavesOutLtrsWiderThanTheyCanBe) {
  TwoSquares world(true);
  std::vector<LtrView> ltrs = world.mesh.ltrs;
  ltrs[0].corners[0] = Vector2d(-1e12, -1e12);
  const int unusable = ltrs[0].id;
  EXPECT_EQ(world.planner.setLtrs(ltrs), std::vector<int>{unusable});
  world.planner.prepare(Vector2d::Zero());
  EXPECT_NE(world.plan({4.0, 9.0}, {14.0, 9.0}).status, PlanStatus::kCancelled);
}

TEST(DoorPlanner, LeavesOutLtrsOfSenselessNumbers) {
  TwoSquares world(true);
  for (const int number : {std::numeric_limits<int>::max(), -1, -7}) {
    std::vector<LtrView> ltrs = world.mesh.ltrs;
    ltrs[0].id = number;
    EXPECT_EQ(world.planner.setLtrs(ltrs), std::vector<int>{number});
  }
  EXPECT_TRUE(world.planner.setLtrs(world.mesh.ltrs).empty());
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

TEST(DoorPlanner, ComputesNothingAnewWhenTheMapTurnsAndShifts) {
  World world(wallWithGap(30.0, 4.0));
  const Plan before = world.plan({8.0, 8.0}, {40.0, 8.0});
  const std::size_t matrices = world.planner.counts().matrices;
  const Pose2 moved{100.0, -40.0, 1.0};
  test::Landmarks landmarks;
  for (const Vector2d& landmark : world.mesh.landmarks) landmarks.push_back(moved * landmark);
  world.mesh.moveTo(landmarks);
  world.planner.setLtrs(world.mesh.ltrs);
  EXPECT_EQ(world.planner.prepare(Vector2d::Zero()), 0U);
  EXPECT_EQ(world.planner.counts().matrices, matrices);
  const Plan after = world.plan(moved * Vector2d(8.0, 8.0), moved * Vector2d(40.0, 8.0));
  ASSERT_EQ(after.status, PlanStatus::kOk);
  EXPECT_NEAR(after.cost, before.cost, 1e-4 * before.cost);
}

TEST(DoorPlanner, ComputesAnewWhatWasDeformed) {
  World world(freeGround);
  const std::size_t matrices = world.planner.counts().matrices;
  test::Landmarks landmarks = world.mesh.landmarks;
  landmarks[12] += Vector2d(1.0, 0.0);  // the one in the middle, which spans six LTRs
  world.mesh.moveTo(landmarks);
  world.planner.setLtrs(world.mesh.ltrs);
  world.planner.prepare(Vector2d::Zero());
  EXPECT_GE(world.planner.counts().matrices, matrices + 6);
  EXPECT_LE(world.planner.counts().matrices, matrices + 16) << "these and their neighbours";
  const Plan plan = world.plan({5.0, 6.0}, {40.0, 33.0});
  EXPECT_NEAR(plan.cost, plan.length_m, 1e-6);
}

TEST(DoorPlanner, ComputesNothingAnewForTheSameContent) {
  World world(wallWithGap(30.0, 4.0));
  const DoorMap::Counts before = world.planner.counts();
  world.show(wallWithGap(30.0, 4.0));
  EXPECT_EQ(world.planner.counts().matrices, before.matrices);
  EXPECT_EQ(world.planner.counts().unchanged_contents, world.mesh.ltrs.size());
}

void expectSameGraph(const DoorGraph& one, const DoorGraph& other) {
  ASSERT_EQ(one.ltrs().size(), other.ltrs().size());
  ASSERT_EQ(one.portalCount(), other.portalCount());
  for (int number = 0; number < static_cast<int>(one.ltrs().size()); ++number) {
    ASSERT_EQ(one.ltr(number).matrix->size(), other.ltr(number).matrix->size());
    EXPECT_TRUE(*one.ltr(number).costs == *other.ltr(number).costs);
    const int size = one.ltr(number).matrix->size();
    EXPECT_TRUE(std::equal(one.searchLtr(number).costs, one.searchLtr(number).costs + size * size,
                           other.searchLtr(number).costs));
  }
}

TEST(DoorPlanner, SharesWhatAChangeOfContentsLeavesAsItWas) {
  World world(freeGround);
  const auto before = world.planner.graph();
  const Vector2d middle = before->ltr(9).triangle.toGlobal({0.33, 0.33});
  const Occupancy post = [middle](const Vector2d& p) {
    return (p - middle).norm() < 0.3 ? 1.0F : 0.0F;
  };
  world.show(post);
  const auto after = world.planner.graph();
  EXPECT_EQ(after->searchPlaces(), before->searchPlaces()) << "doors are where they were";
  expectSameGraph(*after, *World(post).planner.graph());
  world.show(wallWithGap(30.0, 4.0));
  EXPECT_NE(world.planner.graph()->searchPlaces(), before->searchPlaces());
  expectSameGraph(*world.planner.graph(), *World(wallWithGap(30.0, 4.0)).planner.graph());
  world.show(freeGround);
  expectSameGraph(*world.planner.graph(), *before);
}

TEST(DoorPlanner, KeepsDistrictsInWhichNothingChanged) {
  DoorPlannerConfig config;
  config.district_m = 12.0;
  World world(freeGround, config);
  EXPECT_EQ(world.planner.districts(), nullptr);
  EXPECT_EQ(world.planner.prepareDistricts(), 0U);
  const auto before = world.planner.districts();
  const Vector2d middle = before->graph()->ltr(9).triangle.toGlobal({0.33, 0.33});
  world.show([middle](const Vector2d& p) { return (p - middle).norm() < 0.3 ? 1.0F : 0.0F; });
  EXPECT_EQ(world.planner.districts(), nullptr) << "those of a map that was";
  EXPECT_EQ(world.planner.prepareDistricts(0), 1U);
  EXPECT_EQ(world.planner.prepareDistricts(), 0U);
  EXPECT_EQ(world.planner.districts()->count(), before->count());
  for (LtrView& ltr : world.mesh.ltrs) ltr.shape_factor = 1.1;
  world.planner.setLtrs(world.mesh.ltrs);
  world.planner.prepare(Vector2d::Zero());
  EXPECT_EQ(world.planner.prepareDistricts(0), before->count()) << "all factors have changed";
}

TEST(DoorPlanner, PaysForUncertainShapes) {
  World world(freeGround);
  for (LtrView& ltr : world.mesh.ltrs) ltr.shape_factor = 1.2;
  world.planner.setLtrs(world.mesh.ltrs);
  world.planner.prepare(Vector2d::Zero());
  const Plan plan = world.plan({5.0, 6.0}, {40.0, 33.0});
  EXPECT_NEAR(plan.cost_with_uncertainty, 1.2 * plan.cost, 1e-6);
  EXPECT_DOUBLE_EQ(plan.worst_shape_factor, 1.2);
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

/// Being at a portal in one of its side's two LTRs.
std::size_t stateOf(const DoorGraph& graph, int portal, int ltr) {
  return 2 * std::size_t(portal) + (graph.side(graph.sideOf(portal)).ltrs[0] == ltr ? 0 : 1);
}

/// Cheapest costs from a portal, in one of its LTRs, by Bellman and Ford over every pair of portals
/// of every LTR and every crossing.
std::vector<double> cheapestAlongPortals(const DoorGraph& graph, int from, int in) {
  std::vector<double> cost(2 * std::size_t(graph.portalCount()), kNoPassing);
  cost[stateOf(graph, from, in)] = 0.0;
  bool changed = true;
  const auto offer = [&](std::size_t a, std::size_t b, double step) {
    if (!(cost[a] + step < cost[b] * (1.0 - 1e-9))) return;
    cost[b] = cost[a] + step;
    changed = true;
  };
  while (std::exchange(changed, false)) {
    for (int number = 0; number < static_cast<int>(graph.ltrs().size()); ++number) {
      const GraphLtr& ltr = graph.ltr(number);
      for (int a = 0; a < ltr.first_portal[3]; ++a) {
        const int portal = graph.portalAt(number, a);
        for (int b = 0; b < ltr.first_portal[3]; ++b) {
          offer(stateOf(graph, portal, number), stateOf(graph, graph.portalAt(number, b), number),
                ltr.factor * static_cast<double>(ltr.matrix->cost(a, b)));
        }
        const int k = graph.sideOf(portal);
        const std::size_t here = graph.side(k).ltrs[0] == number ? 0 : 1;
        offer(stateOf(graph, portal, number), stateOf(graph, portal, graph.side(k).ltrs[1 - here]),
              static_cast<double>(graph.crossing(graph.searchSide(k),
                                                 portal - graph.side(k).first_portal, 1 - here)));
      }
    }
  }
  return cost;
}

/// Discs in LTRs with factors of their own; in every other world heights that are dear to climb.
/// Deformed by less than what makes costs out of date: lengths have grown, costs have not.
struct UnevenWorld : World {
  explicit UnevenWorld(std::uint64_t seed) : World(freeGround, configOf(seed)) {
    RandomGenerator generator(seed);
    const Occupancy occupancy = discs(seed, 30, 48.0, {});
    for (const LtrView& ltr : mesh.ltrs) {
      LtrContent content = test::contentOf(ltr, occupancy);
      content.properties["height"] =
          test::contentOf(ltr, [](const Vector2d& p) {
            return static_cast<float>(3.0 * std::sin(0.2 * p.x()) * std::sin(0.15 * p.y()));
          }).occupancy;
      planner.setContent(ltr.id, content);
    }
    for (LtrView& ltr : mesh.ltrs) ltr.shape_factor = sampleUniform(generator, 1.0, 1.3);
    planner.setLtrs(mesh.ltrs);
    planner.prepare(Vector2d::Zero());
    const std::size_t matrices = planner.counts().matrices;
    test::Landmarks moved;
    for (const Vector2d& landmark : mesh.landmarks) moved.push_back(1.005 * landmark);
    mesh.moveTo(moved);
    planner.setLtrs(mesh.ltrs);
    planner.prepare(Vector2d::Zero());
    EXPECT_EQ(planner.counts().matrices, matrices);
    planner.prepareDistricts();
  }
  static DoorPlannerConfig configOf(std::uint64_t seed) {
    DoorPlannerConfig config;
    config.district_m = 10.0 + static_cast<double>(seed);
    if (seed % 2 == 0) config.cost.properties = "height climb 2";
    return config;
  }
};

/// What a route costs from its first portal to its last, LTR by LTR.
double costBetweenPortals(const DoorGraph& graph, const DoorRoute& route) {
  double sum = 0.0;
  const Waypoint* before = nullptr;
  for (const Waypoint& waypoint : route.waypoints) {
    if (waypoint.portal == kNone) continue;
    if (before != nullptr) {
      const int through = waypoint.place.ltr, from = before->portal;
      const int number = graph.sideOf(from);
      const GraphSide& side = graph.side(number);
      const std::size_t end = side.ltrs[0] == through ? 0 : 1;
      if (side.ltrs[end] != through) return kNoPassing;
      if (before->place.ltr != through) {
        sum += static_cast<double>(
            graph.crossing(graph.searchSide(number), from - side.first_portal, end));
      }
      sum += graph.ltr(through).factor *
             static_cast<double>(graph.ltr(through).matrix->cost(
                 graph.portalIn(through, from), graph.portalIn(through, waypoint.portal)));
    }
    before = &waypoint;
  }
  return sum;
}

TEST(DoorSearch, IsOptimalOverTheDoorGraphWithDistrictsAndWithout) {
  std::size_t crossed = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const UnevenWorld world(seed);
    const std::shared_ptr<const DoorGraph> graph = world.planner.graph();
    const std::shared_ptr<const Districts> districts = world.planner.districts();
    ASSERT_EQ(districts->missing(), 0U);
    ASSERT_GE(districts->count(), 9U);
    RandomGenerator generator(seed);
    DoorSearch search;
    for (int trial = 0; trial < 12; ++trial) {
      const auto portal = [&] {
        return static_cast<int>(sampleUniform(generator, 0.0, graph->portalCount()));
      };
      const auto placeAt = [&](int p) {
        const int ltr = graph->side(graph->sideOf(p)).ltrs[0];
        return GraphPlace{ltr, graph->localOf(ltr, p)};
      };
      const int from = portal(), to = portal();
      const GraphPlace start = placeAt(from), goal = placeAt(to);
      DoorRoute alone, together;
      const SearchOutcome outcome = search.find(*graph, start, goal, {}, alone);
      DoorSearch::Options options;
      options.districts = districts.get();
      ASSERT_EQ(search.find(*graph, start, goal, options, together), outcome);
      const double cheapest =
          cheapestAlongPortals(*graph, from, start.ltr)[stateOf(*graph, to, goal.ltr)];
      ASSERT_EQ(outcome == SearchOutcome::kFound, cheapest < kNoPassing);
      if (outcome != SearchOutcome::kFound) continue;
      EXPECT_LE(alone.cost, cheapest * (1.0 + 1e-5) + 1e-9);
      EXPECT_NEAR(together.cost, alone.cost, 1e-5 * alone.cost);
      EXPECT_LE(costBetweenPortals(*graph, together), together.cost * (1.0 + 1e-5) + 1e-9);
      crossed += together.expanded < alone.expanded ? 1 : 0;
    }
  }
  EXPECT_GT(crossed, 0U) << "no district was crossed at once";
}

/// Free ground with one more layer, or several, by what is to be the value at a place.
using Layers = std::map<std::string, Occupancy>;
void show(World& world, const Layers& layers) {
  for (const LtrView& ltr : world.mesh.ltrs) {
    LtrContent content = test::contentOf(ltr, freeGround);
    for (const auto& [name, value] : layers) {
      content.properties[name] = test::contentOf(ltr, value).occupancy;
    }
    world.planner.setContent(ltr.id, content);
  }
  world.planner.prepare(Vector2d::Zero());
}

TEST(DoorPlanner, PaysForClimbingAcrossSidesToo) {
  DoorPlannerConfig config;
  config.cost.properties = "height climb 5";
  World world(freeGround, config);
  // The rise of one cell, 0.1 each, would be missing at each of the seven sides on the way. In
  // sheared cells a level line goes up and down by less than half of that.
  show(world, {{"height", [](const Vector2d& p) { return static_cast<float>(0.1 * p.x()); }}});
  const Plan up = world.plan({5.0, 8.0}, {43.0, 8.0}), down = world.plan({43.0, 8.0}, {5.0, 8.0});
  ASSERT_GT(up.doors.size(), 5U);
  EXPECT_NEAR(up.cost, 38.0 + 5.0 * 3.8, 0.35);
  EXPECT_NEAR(down.cost, 38.0, 0.35);
}

TEST(DoorPlanner, WeighsSeveralLayersEachWithItsOwnRises) {
  DoorPlannerConfig config;
  config.cost.properties = "height climb 5; slope climb 5; mud 0.5";
  World world(freeGround, config);
  // What one layer rises the other falls: neither pays for the other.
  show(world, {{"height", [](const Vector2d& p) { return static_cast<float>(0.1 * p.x()); }},
               {"slope", [](const Vector2d& p) { return static_cast<float>(-0.1 * p.x()); }},
               {"mud", [](const Vector2d&) { return 1.0F; }}});
  EXPECT_NEAR(world.plan({5.0, 8.0}, {43.0, 8.0}).cost, 1.5 * 38.0 + 5.0 * 3.8, 0.35);
  EXPECT_NEAR(world.plan({43.0, 8.0}, {5.0, 8.0}).cost, 1.5 * 38.0 + 5.0 * 3.8, 0.35);
}

TEST(DoorPlanner, GoesOneWayThroughAGateAndRoundItTheOtherWay) {
  DoorPlannerConfig config;
  config.cost.properties = "gate.in>out one_way 1000";
  World world(freeGround, config);
  const auto strip = [](double from, double to) {
    return [=](const Vector2d& p) {
      return p.x() > from && p.x() < to && (p.y() < 30.0 || p.y() > 34.0) ? 1.0F : 0.0F;
    };
  };
  show(world, {{"gate.in", strip(22.0, 23.5)}, {"gate.out", strip(23.5, 25.0)}});
  const Plan through = world.plan({8.0, 8.0}, {40.0, 8.0});
  EXPECT_NEAR(through.cost, 32.0, 1e-3);
  const Plan around = world.plan({40.0, 8.0}, {8.0, 8.0});
  EXPECT_GT(around.cost, 2.0 * std::hypot(16.0, 22.0));
  EXPECT_LT(around.cost, 2.0 * std::hypot(16.0, 22.0) * 1.05);
}

TEST(DoorPlanner, TakesWeightsThatARequestBrings) {
  World world(freeGround);
  show(world, {{"mud", [](const Vector2d& p) {
                  return std::abs(p.x() - 24.0) < 4.0 && p.y() < 20.0 ? 1.0F : 0.0F;
                }}});
  PlanRequest request;
  request.start = {8.0, 8.0};
  request.goal = {40.0, 8.0};
  EXPECT_NEAR(world.planner.plan(request).cost, 32.0, 1e-3);
  request.weights = "mud 10";
  const Plan dry = world.planner.plan(request);
  ASSERT_TRUE(dry.ok()) << dry.sentence;
  EXPECT_GT(dry.length_m, 2.0 * std::hypot(12.0, 12.0));
  request.weights = "distance 2";
  EXPECT_NEAR(world.planner.plan(request).cost, 64.0, 1e-3);
  request.weights.clear();
  EXPECT_NEAR(world.planner.plan(request).cost, 32.0, 1e-3) << "others are not concerned";
  // The map moves on under weights that are kept.
  show(world, {});
  request.weights = "mud 10";
  EXPECT_NEAR(world.planner.plan(request).cost, 32.0, 1e-3);
}

TEST(DoorPlanner, RefusesWeightsOfARequestThatCannotBeUsed) {
  const World world(freeGround);
  PlanRequest request;
  request.start = {8.0, 8.0};
  request.goal = {40.0, 8.0};
  for (const auto& [weights, words] :
       {std::make_pair("mud -1", "'mud -1'"), std::make_pair("mud", "'mud'"),
        std::make_pair("distance 0; occupancy 0; unknown 0", "cost nothing"),
        std::make_pair("a.b>c 3", "'a.b>c 3'")}) {
    request.weights = weights;
    const Plan plan = world.planner.plan(request);
    EXPECT_EQ(plan.status, PlanStatus::kBadRequest) << weights;
    EXPECT_THAT(plan.sentence, testing::HasSubstr(words));
  }
  request.weights = "mud 1";
  EXPECT_EQ(DoorPlanner(DoorPlannerConfig()).plan(request).status, PlanStatus::kNoMap);
}

TEST(DoorPlanner, KeepsWhatItHasComputedForWeightsWhenItIsInterrupted) {
  const World world(discs(3, 30, 48.0, {{5.0, 5.0}, {43.0, 43.0}}));
  PlanRequest request;
  request.start = {5.0, 5.0};
  request.goal = {43.0, 43.0};
  request.weights = "unknown 5";
  request.interrupted = [] { return PlanStatus::kTimeout; };
  const Plan first = world.planner.plan(request);
  EXPECT_EQ(first.status, PlanStatus::kTimeout);
  EXPECT_THAT(first.sentence, testing::HasSubstr("ask again"));
  request.interrupted = nullptr;
  EXPECT_TRUE(world.planner.plan(request).ok());
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
