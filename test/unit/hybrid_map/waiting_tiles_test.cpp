#include "hybrid_map/waiting_tiles.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <utility>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "hybrid_map/log_odds.h"
#include "small_maps.h"

namespace hymm::core {
namespace {

using Status = LayerQuery::Status;

TEST(HybridMap, KeepsWhatLiesOutsideUntilAnLtrCoversIt) {
  LandmarkMap all = squareMap();
  LandmarkMap three = all;
  three.landmarks.resize(3);
  correlate(three);
  HybridMap map = mapOver(three);
  const Eigen::Vector2d place(-6.0, 6.0);
  ASSERT_EQ(map.query("salinity", place).status, Status::kOutside);
  map.insert(salinity(place, 20.0));
  EXPECT_EQ(map.evidenceInLtrs(1), 0.0);
  EXPECT_EQ(map.evidenceWaiting(1), 1.0);
  all.version = 2;
  ASSERT_EQ(map.apply(all).change.created.size(), 1U);
  EXPECT_NEAR(map.evidenceInLtrs(1), 1.0, 1e-6);
  EXPECT_NEAR(map.evidenceWaiting(1), 0.0, 1e-6);
  const LayerQuery answer = map.query("salinity", place);
  ASSERT_EQ(answer.status, Status::kKnown);
  EXPECT_NEAR(answer.value->value, 20.0, 1e-5);
}

TEST(HybridMap, APostInFreeSpaceStaysOccupiedWhereverItFallsInTheCellsItMovesTo) {
  LandmarkMap all = squareMap();
  all.version = 2;
  LandmarkMap three = squareMap();
  three.landmarks.resize(3);
  correlate(three);
  for (double along = 0.0; along < 0.4; along += 0.03) {
    const Eigen::Vector2d post(-6.0 + along, 6.0 + 0.7 * along);
    HybridMap map = mapOver(three);
    for (int scan = 0; scan < 20; ++scan) {
      for (double y = -1.0; y <= 1.0; y += 0.1) {
        const bool meets = std::abs(y) < 0.02;
        map.insert(beam({post.x() - 2.0, post.y() + y, 0.0}, meets ? 2.0 : 3.5));
      }
    }
    ASSERT_EQ(map.apply(all).change.created.size(), 1U);
    double most = 0.0;
    for (double x = -0.15; x <= 0.15; x += 0.05) {
      for (double y = -0.15; y <= 0.15; y += 0.05) {
        most = std::max(most, probabilityAt(map, post + Eigen::Vector2d(x, y)));
      }
    }
    EXPECT_GT(most, 0.65) << along;
    EXPECT_LT(probabilityAt(map, post + Eigen::Vector2d(-0.5, 0.0)), 0.35) << along;
  }
}

TEST(HybridMap, WhatWaitsFollowsTheTwoLandmarksThatItIsAnchoredTo) {
  LandmarkMap two = mapOf({{0.0, 0.0}, {8.0, 0.0}});
  HybridMap map = mapOver(two);
  map.insert(salinity({4.0, 5.0}, 20.0));
  const Pose2 correction{-7.0, 11.0, 2.0};
  LandmarkMap three = mapOf({{0.0, 0.0}, {8.0, 0.0}, {4.0, 9.0}});
  for (auto& landmark : three.landmarks) landmark.position = correction * landmark.position;
  three.version = 2;
  ASSERT_EQ(map.apply(three).change.created.size(), 1U);
  const LayerQuery answer = map.query("salinity", correction * Eigen::Vector2d(4.0, 5.0));
  ASSERT_EQ(answer.status, Status::kKnown);
  EXPECT_NEAR(answer.value->value, 20.0, 1e-5);
}

TEST(HybridMap, ASheetIsWrittenOnWhereverItIsNear) {
  HybridMapConfig config = withLayers();
  config.partition.min_observations = 1000;  // no LTRs
  HybridMap map(config);
  map.apply(mapOf({{0.0, 0.0}, {12.0, 0.0}, {6.0, 12.0}, {18.0, 12.0}}));
  // On the way back other landmarks are nearer than those by which the way there was kept.
  for (const double y : {-4.0, 15.0}) map.insert(beam({9.0, y, 0.0}, 5.0));
  std::set<std::uint64_t> sheets;
  map.waiting().visitTiles(LayerSet::kOccupancy,
                           [&](const WaitingTile& tile) { sheets.insert(tile.sheet); });
  EXPECT_EQ(sheets.size(), 1U);
}

TEST(HybridMap, DropsTheOldestThatWaitsWhenMemoryIsShortAndCountsIt) {
  HybridMapConfig config = withLayers();
  config.occupancy.range_m = 1.0;
  config.waiting.max_memory_mb = 0.07;  // four tiles of salinity
  HybridMap map(config);
  for (int i = 0; i < 5; ++i) map.insert(salinity({50.0 * i, 0.0}, 1.0));
  EXPECT_EQ(map.counts().dropped_waiting_tiles, 1U);
  EXPECT_EQ(map.evidenceWaiting(1), 4.0);
  EXPECT_LE(map.waitingMemory().bytes(), 70000U);
  map.waiting().visitTiles(map.layers().find("salinity"),
                           [](const WaitingTile& tile) { EXPECT_GE(tile.x, 1); });
}

/// All around nothing is met.
PosedScan clearAround(const Eigen::Vector2d& place) {
  constexpr int kBeams = 720;
  PosedScan posed = beam({place.x(), place.y(), 0.0}, 1.0, 0);
  posed.scan.angle_increment_rad = 2.0 * M_PI / kBeams;
  posed.scan.ranges_m.assign(kBeams, std::numeric_limits<float>::infinity());
  return posed;
}

std::set<std::pair<int, int>> tilesOf(const HybridMap& map) {
  std::set<std::pair<int, int>> tiles;
  map.waiting().visitTiles(LayerSet::kOccupancy, [&](const WaitingTile& tile) {
    tiles.insert({tile.x, tile.y});
  });
  return tiles;
}

TEST(HybridMap, OfWhatWasSeenAtOnceTheFarthestFromTheVehicleIsDropped) {
  // Without landmarks there is one sheet, whose axes are those of the map.
  HybridMapConfig config;
  config.occupancy.clear_range_m = config.occupancy.range_m;
  const double scan_mb = WaitingConfig::scanMemory_mb(config.occupancy.range_m, 0.2);
  for (const double vehicle_x : {-100.0, 100.0}) {
    config.waiting.max_memory_mb = 1.1 * scan_mb;
    HybridMap map(config);
    ASSERT_TRUE(map.insert(clearAround({0.0, 0.0})).accepted);
    const std::set<std::pair<int, int>> before = tilesOf(map);
    const Eigen::Vector2d vehicle(vehicle_x, 3.0);
    ASSERT_TRUE(map.insert(clearAround(vehicle)).accepted);
    const std::set<std::pair<int, int>> after = tilesOf(map);
    const double tile_m = WaitingTile::kCells * config.resolution_m;
    double farthest_kept = 0.0, nearest_dropped = std::numeric_limits<double>::infinity();
    std::size_t dropped = 0;
    for (const auto& [x, y] : before) {
      const double distance = (tile_m * Eigen::Vector2d(x + 0.5, y + 0.5) - vehicle).norm();
      if (after.count({x, y}) > 0) {
        farthest_kept = std::max(farthest_kept, distance);
      } else {
        nearest_dropped = std::min(nearest_dropped, distance);
        ++dropped;
      }
    }
    ASSERT_GT(dropped, 0U);
    ASSERT_LT(dropped, before.size());
    EXPECT_EQ(map.counts().dropped_waiting_tiles, dropped);
    EXPECT_LE(farthest_kept, nearest_dropped);
    EXPECT_LE(double(map.waitingMemory().bytes()), 1e6 * config.waiting.max_memory_mb);
  }
}

TEST(HybridMap, AScanFitsTheMemoryThatItIsSaidToNeed) {
  for (const double range_m : {1.0, 10.0, 30.0}) {
    HybridMapConfig config;
    config.occupancy.range_m = range_m;
    const double most_mb = WaitingConfig::scanMemory_mb(range_m, config.resolution_m);
    for (const double offset_m : {0.0, 1.5, 3.1, 5.9}) {
      HybridMap map(config);
      ASSERT_TRUE(map.insert(clearAround({offset_m, offset_m})).accepted);
      EXPECT_LE(double(map.waitingMemory().bytes()), 1e6 * most_mb) << range_m;
    }
  }
}

}  // namespace
}  // namespace hymm::core
