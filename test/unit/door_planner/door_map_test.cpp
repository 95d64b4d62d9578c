#include "door_planner/door_map.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "support/planner_worlds.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;
using test::freeGround;
using test::Occupancy;
using test::wallWithGap;
using World = test::PlannerWorld;

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

/// A map of 288 LTRs that nothing was computed of yet.
DoorMap unpreparedMap() {
  const test::SquareMesh mesh(12, 12, 12.0, 0.3, 2.0, 3);
  const Occupancy obstacles = test::discs(5, 60, 144.0, {});
  DoorMap map{DoorPlannerConfig{}};
  map.setLtrs(mesh.ltrs);
  for (const LtrView& ltr : mesh.ltrs) map.setContent(ltr.id, test::contentOf(ltr, obstacles));
  return map;
}

TEST(DoorMap, EndsBetweenFewLtrsWhenItIsInterruptedAndGoesOnFromThere) {
  DoorMap whole = unpreparedMap(), parts = unpreparedMap();
  EXPECT_EQ(whole.prepare(Vector2d::Zero(), 1000), 0U);
  const std::size_t all = whole.counts().blocked;
  EXPECT_GE(all, 288U);
  for (std::size_t left = 1; left > 0;) {
    const DoorMap::Counts before = parts.counts();
    left = parts.prepare(Vector2d::Zero(), 1000, [] { return true; });
    const std::size_t blocked = parts.counts().blocked - before.blocked;
    const std::size_t matrices = parts.counts().matrices - before.matrices;
    ASSERT_GT(left == 0 ? 1 : blocked + matrices, 0U) << "each call gets on";
    EXPECT_LT(blocked, all / 2);
    EXPECT_LT(matrices, 20U);
  }
  EXPECT_EQ(parts.counts().blocked, all) << "nothing is done twice";
  EXPECT_EQ(parts.counts().matrices, whole.counts().matrices);
  expectSameGraph(*parts.makeGraph(), *whole.makeGraph());
}

TEST(DoorMap, TakesChangesWhileItIsInterrupted) {
  DoorMap whole = unpreparedMap(), parts = unpreparedMap();
  const auto goOn = [&] { return parts.prepare(Vector2d::Zero(), 1000, [] { return true; }); };
  const test::SquareMesh mesh(12, 12, 12.0, 0.3, 2.0, 3);
  for (std::size_t changed = 0; changed < mesh.ltrs.size(); changed += 40) {
    const LtrContent content = test::contentOf(mesh.ltrs[changed], freeGround);
    goOn();
    parts.setContent(mesh.ltrs[changed].id, content);
    whole.setContent(mesh.ltrs[changed].id, content);
  }
  while (goOn() > 0) continue;
  whole.prepare(Vector2d::Zero(), 1000);
  expectSameGraph(*parts.makeGraph(), *whole.makeGraph());
}

TEST(DoorPlanner, LeavesOutLtrsOfMoreCellsThanMemoryHas) {
  World world(freeGround);
  std::vector<LtrView> ltrs = world.mesh.ltrs;
  ltrs[0].alpha_cells = ltrs[0].beta_cells = std::numeric_limits<int>::max();
  EXPECT_EQ(world.planner.setLtrs(ltrs), (UnusableLtrs{{ltrs[0].id, LtrProblem::kTooManyCells}}));
  EXPECT_TRUE(world.planner.setLtrs(world.mesh.ltrs).empty());
}

TEST(DoorPlanner, LeavesOutLtrsWiderThanTheyCanBe) {
  World world(freeGround);
  std::vector<LtrView> ltrs = world.mesh.ltrs;
  ltrs[0].corners[0] = Vector2d(-1e6, -1e6);
  const int unusable = ltrs[0].id;
  EXPECT_EQ(world.planner.setLtrs(ltrs), (UnusableLtrs{{unusable, LtrProblem::kTooWide}}));
  world.planner.prepare(Vector2d::Zero());
  EXPECT_NE(world.plan({4.0, 9.0}, {14.0, 9.0}).status, PlanStatus::kCancelled);
}

TEST(DoorPlanner, LeavesOutLtrsThatAreNextToALine) {
  World world(freeGround);
  std::vector<LtrView> ltrs = world.mesh.ltrs;
  LtrView& ltr = ltrs[0];
  // As many cells as are 0.2 m wide, along the longest sides, with the third vertex between them.
  ltr.corners = {Vector2d(0.0, 0.0), Vector2d(20.0, 0.0), Vector2d(10.0, 0.0)};
  ltr.alpha_cells = 100;
  ltr.beta_cells = 50;
  for (const double height_m : {1e-4, 1e-3, 1e-2}) {
    ltr.corners[2].y() = height_m;
    EXPECT_EQ(world.planner.setLtrs(ltrs), (UnusableLtrs{{ltr.id, LtrProblem::kNarrowCells}}))
        << height_m;
  }
  // 0.02 rad, the least that new LTRs can be made to have being 0.01.
  ltr.corners[2].y() = 0.2;
  EXPECT_TRUE(world.planner.setLtrs(ltrs).empty());
  // A few cells that are long and narrow need as many steps.
  ltr = world.mesh.ltrs[0];
  ltr.alpha_cells = 1 << 20;
  ltr.beta_cells = 1;
  EXPECT_EQ(world.planner.setLtrs(ltrs), (UnusableLtrs{{ltr.id, LtrProblem::kNarrowCells}}));
}

TEST(DoorPlanner, LeavesOutLtrsOfSenselessNumbers) {
  World world(freeGround);
  for (const int number : {std::numeric_limits<int>::max(), -1, -7}) {
    std::vector<LtrView> ltrs = world.mesh.ltrs;
    ltrs[0].id = number;
    EXPECT_EQ(world.planner.setLtrs(ltrs), (UnusableLtrs{{number, LtrProblem::kId}}));
  }
  EXPECT_TRUE(world.planner.setLtrs(world.mesh.ltrs).empty());
  const auto problemWith = [&](const std::function<void(LtrView&)>& change) {
    LtrView ltr = world.mesh.ltrs[0];
    change(ltr);
    return problemOf(ltr);
  };
  EXPECT_EQ(problemWith([](LtrView&) {}), std::nullopt);
  EXPECT_EQ(problemWith([](LtrView& ltr) { ltr.corners[0] = Vector2d(-1e12, -1e12); }),
            LtrProblem::kPlace);
  EXPECT_EQ(problemWith([](LtrView& ltr) { ltr.corners[2].x() = std::nan(""); }),
            LtrProblem::kPlace);
  EXPECT_EQ(problemWith([](LtrView& ltr) { std::swap(ltr.corners[0], ltr.corners[1]); }),
            LtrProblem::kFlat);
  EXPECT_EQ(problemWith([](LtrView& ltr) { ltr.corners[2] = ltr.corners[1]; }), LtrProblem::kFlat);
  EXPECT_EQ(problemWith([](LtrView& ltr) { ltr.beta_cells = -3; }), LtrProblem::kNoCells);
}

}  // namespace
}  // namespace hymm::core
