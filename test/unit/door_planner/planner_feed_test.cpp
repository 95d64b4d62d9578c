#include "door_planner/planner_feed.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/planner_meshes.h"
#include "support/shipped_config.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;

TEST(DecodeLayer, ReadsEachCellModel) {
  LtrContent content;
  ASSERT_TRUE(decodeLayer("occupancy", "occupancy", 1, {0.0F, 2.0F}, content));
  EXPECT_TRUE(std::isnan(content.occupancy[0]));
  EXPECT_FLOAT_EQ(content.occupancy[1], 1.0F / (1.0F + std::exp(-2.0F)));
  ASSERT_TRUE(decodeLayer("height", "gaussian", 4, {0, 0, 0, 0, 4, 1.5F, 0, 2}, content));
  EXPECT_TRUE(std::isnan(content.properties["height"][0]));
  EXPECT_FLOAT_EQ(content.properties["height"][1], 1.5F);
  ASSERT_TRUE(decodeLayer("terrain", "category grass mud", 2, {3, 1, 0, 0}, content));
  EXPECT_FLOAT_EQ(content.properties["terrain.mud"][0], 0.25F);
  EXPECT_TRUE(std::isnan(content.properties["terrain.grass"][1]));
  ASSERT_TRUE(decodeLayer("traffic", "rate", 4, {6, 2, 0, 1, 0, 0, 0, 0}, content));
  EXPECT_FLOAT_EQ(content.properties["traffic"][0], 2.0F);
  EXPECT_TRUE(std::isnan(content.properties["traffic"][1]));
}

TEST(DecodeLayer, RefusesWhatDoesNotFit) {
  LtrContent content;
  EXPECT_FALSE(decodeLayer("occupancy", "occupancy", 2, {0.0F, 2.0F}, content));
  EXPECT_FALSE(decodeLayer("height", "gaussian", 4, {0, 0, 0}, content));
  EXPECT_FALSE(decodeLayer("x", "unheard_of", 1, {0.0F}, content));
  EXPECT_FALSE(decodeLayer("x", "occupancy", 0, {}, content));
}

/// What a map of four LTRs tells.
struct Told {
  test::SquareMesh mesh{2, 1, 14.0, 0.2};
  PlannerFeed feed;
  DoorPlanner planner{DoorPlannerConfig{}};

  void tellTopology() {
    std::vector<LtrTopology> topology;
    for (const LtrView& ltr : mesh.ltrs) {
      topology.push_back(
          {ltr.id, ltr.landmark_ids, ltr.neighbours, ltr.alpha_cells, ltr.beta_cells, 0.0, 1.0});
    }
    feed.setTopology(topology);
  }
  void tellLandmarks(const Vector2d& shift) {
    std::vector<LandmarkEstimate> landmarks;
    for (std::size_t i = 0; i < mesh.landmarks.size(); ++i) {
      LandmarkEstimate landmark;
      landmark.id = static_cast<int>(i);
      landmark.position = mesh.landmarks[i] + shift;
      landmarks.push_back(landmark);
    }
    feed.setLandmarks(landmarks);
  }
  void tellLayers() {
    for (const LtrView& ltr : mesh.ltrs) {
      const int cells = gridOf(ltr.alpha_cells, ltr.beta_cells).cellCount();
      EXPECT_TRUE(feed.setLayer(ltr.id, "occupancy", "occupancy", 1,
                                std::vector<float>(std::size_t(cells), -3.0F)));
    }
  }
  Plan plan(const Vector2d& shift) {
    feed.tell(planner);
    planner.prepare(Vector2d::Zero());
    PlanRequest request;
    request.start = Vector2d(3.0, 3.0) + shift;
    request.goal = Vector2d(25.0, 10.0) + shift;
    return planner.plan(request);
  }
};

TEST(PlannerFeed, TakesMessagesInAnyOrder) {
  for (int order = 0; order < 6; ++order) {
    Told told;
    const std::array<std::array<int, 3>, 6> orders = {
        {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
    for (const int what : orders[std::size_t(order)]) {
      if (what == 0) told.tellTopology();
      if (what == 1) told.tellLandmarks(Vector2d::Zero());
      if (what == 2) told.tellLayers();
      if (order < 2) told.feed.tell(told.planner);
    }
    EXPECT_EQ(told.plan(Vector2d::Zero()).status, PlanStatus::kOk) << "order " << order;
  }
}

TEST(PlannerFeed, TellsLtrsWithoutLayersAsUnknownGround) {
  Told told;
  told.tellTopology();
  told.tellLandmarks(Vector2d::Zero());
  const Plan plan = told.plan(Vector2d::Zero());
  ASSERT_EQ(plan.status, PlanStatus::kOk);
  EXPECT_NEAR(plan.cost, 4.0 * plan.length_m, 1e-3) << "1 for the distance and 3 for unknown";
}

TEST(PlannerFeed, HasNothingToTellTwice) {
  Told told;
  told.tellTopology();
  EXPECT_TRUE(told.feed.tell(told.planner));
  EXPECT_FALSE(told.feed.tell(told.planner));
  told.tellLandmarks(Vector2d(100.0, 0.0));
  EXPECT_TRUE(told.feed.tell(told.planner));
  EXPECT_EQ(told.plan(Vector2d(100.0, 0.0)).status, PlanStatus::kOk);
}

TEST(PlannerFeed, LeavesOutLtrsWhoseLandmarksAreNotKnown) {
  Told told;
  told.tellTopology();
  told.tellLayers();
  EXPECT_EQ(told.plan(Vector2d::Zero()).status, PlanStatus::kNoMap);
  EXPECT_EQ(told.feed.waiting(), 4U);
  told.tellLandmarks(Vector2d::Zero());
  told.feed.tell(told.planner);
  EXPECT_EQ(told.feed.waiting(), 0U);
}

TEST(PlannerFeed, TellsWhichLtrsThePlannerLeavesOutAndWhy) {
  Told told;
  told.mesh.ltrs[1].alpha_cells = 1 << 20;
  told.mesh.ltrs[1].beta_cells = 1 << 10;
  told.mesh.ltrs[3].beta_cells = 0;
  told.tellTopology();
  told.tellLandmarks(Vector2d::Zero());
  told.feed.tell(told.planner);
  const UnusableLtrs expected = {{told.mesh.ltrs[1].id, LtrProblem::kTooManyCells},
                                 {told.mesh.ltrs[3].id, LtrProblem::kNoCells}};
  EXPECT_EQ(told.feed.unusable(), expected);
  EXPECT_THAT(countsOf(told.feed.unusable()),
              testing::ElementsAre(testing::Pair("has more cells than plans have memory for (raise "
                                                 "hymm_grid's resolution_m)",
                                                 1U),
                                   testing::Pair("has no cells", 1U)));
  told.mesh.ltrs = test::SquareMesh(2, 1, 14.0, 0.2).ltrs;
  told.tellTopology();
  told.feed.tell(told.planner);
  EXPECT_TRUE(told.feed.unusable().empty()) << "only what there is now";
}

TEST(DoorPlannerConfig, IsDocumentedByItsShippedFile) {
  test::expectDocumentedByShippedFile("door_planner", DoorPlannerConfig());
}

TEST(DoorPlannerConfig, RefusesAGoalThatIsNoPlace) {
  DoorPlannerConfig config;
  config.goal = "12 here";
  EXPECT_EQ(config.problems().size(), 1U);
  config.goal = "12 -3.5";
  EXPECT_TRUE(config.problems().empty());
  EXPECT_EQ(config.goalPlace(), Vector2d(12.0, -3.5));
}

TEST(PlannerFeed, CountsContentsOfAnotherGrid) {
  Told told;
  told.tellTopology();
  told.tellLandmarks(Vector2d::Zero());
  told.feed.setLayer(0, "occupancy", "occupancy", 1, {1.0F, 2.0F});
  told.feed.tell(told.planner);
  EXPECT_EQ(told.feed.refusedContents(), 1U);
}

}  // namespace
}  // namespace hymm::core
