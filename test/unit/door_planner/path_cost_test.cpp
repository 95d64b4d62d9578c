#include <chrono>
#include <cmath>
#include <future>
#include <map>
#include <string>
#include <thread>
#include <utility>

#include <gmock/gmock.h>

#include "door_planner/door_planner.h"
#include "support/planner_worlds.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;
using test::discs;
using test::freeGround;
using test::Occupancy;
using test::requestFor;
using World = test::PlannerWorld;

TEST(DoorPlanner, PaysForUncertainShapes) {
  World world(freeGround);
  for (LtrView& ltr : world.mesh.ltrs) ltr.shape_factor = 1.2;
  world.planner.setLtrs(world.mesh.ltrs);
  world.planner.prepare(Vector2d::Zero());
  const Plan plan = world.plan({5.0, 6.0}, {40.0, 33.0});
  EXPECT_NEAR(plan.cost_with_uncertainty, 1.2 * plan.cost, 1e-6);
  EXPECT_DOUBLE_EQ(plan.worst_shape_factor, 1.2);
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
  PlanRequest request = requestFor({8.0, 8.0}, {40.0, 8.0});
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

TEST(DoorPlanner, TellsOfWeightsOfLayersThatNobodyMeasured) {
  World world(freeGround);
  show(world, {{"mud", [](const Vector2d&) { return 1.0F; }}});
  PlanRequest request = requestFor({8.0, 8.0}, {40.0, 8.0});
  request.weights = "mud 1; distance 2";
  EXPECT_THAT(world.planner.plan(request).sentence, testing::Not(testing::HasSubstr("No LTR")));
  request.weights = "mut 1; ice.in>out one_way 5";
  const Plan plan = world.planner.plan(request);
  EXPECT_TRUE(plan.ok());
  EXPECT_THAT(plan.sentence,
              testing::AllOf(testing::HasSubstr("'mut'"), testing::HasSubstr("unknown, mud."),
                             testing::HasSubstr("'ice.in'")));
}

TEST(DoorPlanner, RefusesWeightsOfARequestThatCannotBeUsed) {
  const World world(freeGround);
  PlanRequest request = requestFor({8.0, 8.0}, {40.0, 8.0});
  for (const auto& [weights, words] :
       {std::make_pair("mud -1", "'mud -1'"), std::make_pair("mud", "'mud'"),
        std::make_pair("distance 0; occupancy 0; unknown 0", "cost nothing"),
        std::make_pair("distance 1e-40", "cost nothing"),
        std::make_pair("unknown 1e300", "'unknown 1e300'"),
        std::make_pair("mud 1e10", "'mud 1e10'"), std::make_pair("a.b>c 3", "'a.b>c 3'")}) {
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
  PlanRequest request = requestFor({5.0, 5.0}, {43.0, 43.0});
  request.weights = "unknown 5";
  request.interrupted = [] { return PlanStatus::kTimeout; };
  const Plan first = world.planner.plan(request);
  EXPECT_EQ(first.status, PlanStatus::kTimeout);
  EXPECT_THAT(first.sentence, testing::HasSubstr("ask again"));
  // However little each of them may do, requests get there.
  std::size_t interruptions = 0;
  bool may_search = false;
  request.interrupted = [&] { return may_search ? PlanStatus::kOk : PlanStatus::kTimeout; };
  Plan last = first;
  while (last.sentence == first.sentence && ++interruptions < 1000) {
    last = world.planner.plan(request);
  }
  EXPECT_LT(interruptions, 1000U);
  EXPECT_GT(interruptions, 2U);
  may_search = true;
  EXPECT_TRUE(world.planner.plan(request).ok());
}

/// A request whose costs are being computed, and are as long as this lives, but for a minute.
class HeldRequest {
 public:
  HeldRequest(const DoorPlanner& planner, PlanRequest request) {
    request.interrupted = [this] {
      if (!std::exchange(is_inside_, true)) inside_.set_value();
      const auto status = released_.wait_for(std::chrono::minutes(1));
      gave_up_ = gave_up_ || status == std::future_status::timeout;
      return PlanStatus::kOk;
    };
    thread_ = std::thread([&planner, request] { planner.plan(request); });
    inside_.get_future().wait();
  }
  ~HeldRequest() {
    release_.set_value();
    thread_.join();
    EXPECT_FALSE(gave_up_) << "another request waited for it";
  }

 private:
  std::promise<void> inside_, release_;
  std::shared_future<void> released_ = release_.get_future().share();
  bool is_inside_ = false, gave_up_ = false;
  std::thread thread_;
};

TEST(DoorPlanner, WaitsForWeightsThatAnotherRequestPreparesUntilItIsInterrupted) {
  const World world(freeGround);
  PlanRequest request = requestFor({5.0, 5.0}, {43.0, 43.0});
  request.weights = "unknown 5";
  {
    const HeldRequest held(world.planner, request);
    request.interrupted = [] { return PlanStatus::kTimeout; };
    EXPECT_EQ(world.planner.plan(request).status, PlanStatus::kTimeout);
    request.interrupted = [] { return PlanStatus::kCancelled; };
    EXPECT_EQ(world.planner.plan(request).status, PlanStatus::kCancelled);
  }
  request.interrupted = nullptr;
  EXPECT_TRUE(world.planner.plan(request).ok());
}

TEST(DoorPlanner, PreparesTwoSetsOfWeightsAtOnceAndNoMore) {
  const World world(freeGround);
  PlanRequest request = requestFor({5.0, 5.0}, {43.0, 43.0});
  request.weights = "unknown 5";
  {
    const HeldRequest held(world.planner, request);
    request.weights = "unknown 6";
    EXPECT_TRUE(world.planner.plan(request).ok());
    const HeldRequest other(world.planner, [&] {
      PlanRequest third = request;
      third.weights = "unknown 7";
      return third;
    }());
    request.interrupted = [] { return PlanStatus::kTimeout; };
    EXPECT_EQ(world.planner.plan(request).status, PlanStatus::kTimeout);
  }
  request.interrupted = nullptr;
  EXPECT_TRUE(world.planner.plan(request).ok());
}

}  // namespace
}  // namespace hymm::core
