#include "hybrid_map/traffic_counter.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "true_drive.h"

namespace hymm::core {
namespace {

using testing::HasSubstr;

HybridMapConfig counting() {
  HybridMapConfig config;
  config.layers = "traffic rate";
  config.day_parts = 1;
  config.traffic.layer = "traffic";
  return config;
}

std::size_t movingObjectsIn(SimulationConfig simulation, bool with_movers) {
  if (!with_movers) simulation.world.people = simulation.world.moving_cars = 0;
  // In the open park beams without return are the only proof of free space.
  HybridMapConfig config = counting();
  if (simulation.world.name == "park") config.occupancy.clear_range_m = config.occupancy.range_m;
  TrueDrive drive(simulation, config, 2);
  drive.drive();
  return drive.map().counts().moving_objects;
}

TEST(TrafficCounter, CountsCarsAndPeopleThatMoveAndNothingThatStands) {
  const SimulationConfig car_park = worldOf("car_park", 1, 40.0), park = worldOf("park", 1, 60.0);
  const std::size_t cars = movingObjectsIn(car_park, true), people = movingObjectsIn(park, true);
  const std::size_t none_of_cars = movingObjectsIn(car_park, false);
  const std::size_t none_of_people = movingObjectsIn(park, false);
  EXPECT_GT(cars, 20U);
  EXPECT_GT(people, 20U);
  EXPECT_LT(none_of_cars, cars / 10);
  EXPECT_LT(none_of_people, people / 10);
}

/// One beam every degree over half a turn to the front, all of one length but for some.
PosedScan scanAt(double time_s, const std::vector<std::pair<int, double>>& others) {
  PosedScan posed;
  posed.map_version = 1;
  posed.scan.time_s = time_s;
  posed.scan.angle_min_rad = -kPi / 2.0;
  posed.scan.angle_increment_rad = kPi / 180.0;
  posed.scan.range_max_m = 80.0;
  posed.scan.ranges_m.assign(181, 9.0F);
  for (const auto& [beam, range] : others) {
    posed.scan.ranges_m[std::size_t(beam)] = static_cast<float>(range);
  }
  return posed;
}

TEST(TrafficCounter, TellsEventsPerHourWhereSomethingMoved) {
  HybridMap map(counting());
  ASSERT_TRUE(map.apply(mapOf({{-10, -10}, {10, -10}, {10, 10}, {-10.5, 10}})).accepted);
  double time_s = 0.0;
  for (; time_s < 10.0; time_s += 0.25) ASSERT_TRUE(map.insert(scanAt(time_s, {})).accepted);
  EXPECT_EQ(map.counts().moving_objects, 0U);
  // Something passes at 4.5 m ahead for half a second.
  for (int i = 0; i < 2; ++i, time_s += 0.25) {
    map.insert(scanAt(time_s, {{90, 4.5}, {91, 4.5}, {92, 4.5}, {93, 4.5}, {94, 4.5}}));
  }
  for (; time_s < 20.0; time_s += 0.25) map.insert(scanAt(time_s, {}));
  EXPECT_EQ(map.counts().moving_objects, 1U);
  const LayerQuery there = map.query("traffic", {4.5, 0.5});
  ASSERT_TRUE(there.value);
  // One event in the 19 s that have been handed out.
  EXPECT_NEAR(there.value->value, 3600.0 / 19.0, 1.0);
  const LayerQuery beside = map.query("traffic", {4.5, -2.5});
  ASSERT_TRUE(beside.value);
  EXPECT_EQ(beside.value->value, 0.0);
}

TEST(TrafficCounter, OneBeamAloneIsNoObject) {
  HybridMap map(counting());
  ASSERT_TRUE(map.apply(mapOf({{-10, -10}, {10, -10}, {10, 10}, {-10.5, 10}})).accepted);
  for (int i = 0; i < 40; ++i) map.insert(scanAt(0.25 * i, {}));
  map.insert(scanAt(10.0, {{90, 4.5}}));
  for (int i = 0; i < 10; ++i) map.insert(scanAt(10.25 + 0.25 * i, {}));
  EXPECT_EQ(map.counts().moving_objects, 0U);
}

TEST(TrafficCounter, AWallAlongWhichTheLaserLooksIsNoObjectWhenItIsSeenAtLast) {
  // Beam by beam 0.4 m farther away, where beams lie 0.1 m apart: nothing of it looks this way.
  HybridMap map(counting());
  ASSERT_TRUE(map.apply(mapOf({{-10, -10}, {10, -10}, {10, 10}, {-10.5, 10}})).accepted);
  for (int i = 0; i < 40; ++i) map.insert(scanAt(0.25 * i, {}));
  for (int i = 40; i < 43; ++i) {
    map.insert(scanAt(0.25 * i, {{90, 4.5}, {91, 4.9}, {92, 5.3}, {93, 5.7}}));
  }
  for (int i = 43; i < 53; ++i) map.insert(scanAt(0.25 * i, {}));
  EXPECT_EQ(map.counts().moving_objects, 0U);
}

TEST(TrafficCounter, WatchesNoPlaceThatBeamsWithoutReturnDoNotShowToBeFree) {
  HybridMapConfig config = counting();
  config.occupancy.clear_range_m = 4.0;
  HybridMap map(config);
  ASSERT_TRUE(map.apply(mapOf({{-10, -10}, {10, -10}, {10, 10}, {-10.5, 10}})).accepted);
  PosedScan open = scanAt(0.0, {});
  const float nothing_met = std::numeric_limits<float>::infinity();
  open.scan.ranges_m.assign(open.scan.ranges_m.size(), nothing_met);
  for (; open.scan.time_s < 5.0; open.scan.time_s += 0.25) map.insert(open);
  EXPECT_TRUE(map.query("traffic", {2.5, 0.5}).value);
  EXPECT_FALSE(map.query("traffic", {7.5, 0.5}).value);
}

TEST(TrafficCounter, WhatHasComeToStayMovesNoLonger) {
  HybridMap map(counting());
  ASSERT_TRUE(map.apply(mapOf({{-10, -10}, {10, -10}, {10, 10}, {-10.5, 10}})).accepted);
  for (int i = 0; i < 40; ++i) map.insert(scanAt(0.25 * i, {}));
  const auto stand = [&](double from_s, double until_s) {
    for (double time_s = from_s; time_s < until_s; time_s += 0.25) {
      map.insert(scanAt(time_s, {{92, 4.5}, {93, 4.5}, {94, 4.5}, {95, 4.5}, {96, 4.5}}));
    }
  };
  // Who walks has left three cells of 0.2 m within 1.2 s, and the next period tells.
  stand(10.0, 13.0);
  const std::size_t came = map.counts().moving_objects;
  EXPECT_GT(came, 0U);
  stand(13.0, 30.0);
  EXPECT_EQ(map.counts().moving_objects, came);
}

TEST(TrafficCounter, IsRefusedWithoutARateLayer) {
  const auto problemOf = [](const std::string& layers, const std::string& layer) {
    HybridMapConfig config;
    config.layers = layers;
    config.traffic.layer = layer;
    try {
      const HybridMap map(config);
    } catch (const ConfigError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(problemOf("", "traffic"), HasSubstr("no layer 'traffic'"));
  EXPECT_THAT(problemOf("traffic gaussian", "traffic"), HasSubstr("'traffic' cannot count"));
  EXPECT_THAT(problemOf("traffic rate dry wet", "traffic"), HasSubstr("no weather ''"));
  EXPECT_EQ(problemOf("traffic rate", "traffic"), "");
}

}  // namespace
}  // namespace hymm::core
