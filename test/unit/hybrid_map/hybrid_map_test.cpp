#include "hybrid_map/hybrid_map.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>

#include <gmock/gmock.h>

#include "common/random.h"
#include "hybrid_map/log_odds.h"
#include "small_maps.h"

namespace hymm::core {
namespace {

using Status = LayerQuery::Status;

TEST(HybridMap, WritesFreeSpaceAlongABeamAndAnObstacleAtItsEnd) {
  HybridMap map = mapOver(squareMap());
  ASSERT_TRUE(map.insert(beam({-5.0, 0.05, 0.0}, 9.1)).accepted);
  EXPECT_NEAR(probabilityAt(map, {4.1, 0.05}), kHit, 1e-6);
  for (double x = -4.9; x < 3.7; x += 0.1) {
    EXPECT_NEAR(probabilityAt(map, {x, 0.05}), 0.4, 1e-6) << x;
  }
  EXPECT_EQ(map.query("occupancy", {4.5, 0.05}).status, Status::kUnknown);
  EXPECT_EQ(map.query("occupancy", {0.0, 3.0}).status, Status::kUnknown);
}

TEST(HybridMap, AnObstacleIsNotFreedByBeamsOfTheSameScanThatGrazeIt) {
  // A wall at y = 2.1, looked along from a place beside it: beams pass cells in which others end.
  HybridMap map = mapOver(squareMap());
  PosedScan posed = beam({-8.0, 1.5, 0.0}, 1.0);
  posed.scan.angle_min_rad = 0.04;
  posed.scan.angle_increment_rad = 0.002;
  posed.scan.ranges_m.clear();
  for (int i = 0; i < 60; ++i) {
    posed.scan.ranges_m.push_back(
        static_cast<float>(0.6 / std::sin(posed.scan.bearing(std::size_t(i)))));
  }
  ASSERT_TRUE(map.insert(posed).accepted);
  for (std::size_t i = 0; i < posed.scan.ranges_m.size(); ++i) {
    const double bearing = posed.scan.bearing(i);
    const Eigen::Vector2d end =
        Eigen::Vector2d(-8.0, 1.5) +
        double{posed.scan.ranges_m[i]} * Eigen::Vector2d(std::cos(bearing), std::sin(bearing));
    EXPECT_GE(probabilityAt(map, end), kHit - 1e-6) << end.transpose();
  }
}

TEST(HybridMap, LearnsByEquationOneUpToItsBound) {
  HybridMapConfig config = withLayers();
  config.occupancy.hit_probability = 0.7;
  HybridMap map = mapOver(squareMap(), config);
  const Eigen::Vector2d wall(4.1, 0.05);
  for (int i = 1; i <= 10; ++i) {
    map.insert(beam({-5.0, 0.05, 0.0}, 9.1));
    const double odds = std::pow(0.7 / 0.3, i);
    EXPECT_NEAR(probabilityAt(map, wall), std::min(odds / (1.0 + odds), 0.97), 1e-5);
  }
}

TEST(HybridMap, ABeamWithoutReturnIsFreeAsFarAsTheLaserSeesDarkThingsAndBeamsAreWritten) {
  for (const auto& [range_m, clear_range_m] : {std::pair(8.0, 15.0), {15.0, 8.0}}) {
    HybridMapConfig config = withLayers();
    config.occupancy.range_m = range_m;
    config.occupancy.clear_range_m = clear_range_m;
    HybridMap map = mapOver(squareMap(), config);
    map.insert(beam({-5.0, 0.05, 0.0}, std::numeric_limits<double>::infinity()));
    EXPECT_LT(probabilityAt(map, {2.9, 0.05}), 0.5);
    EXPECT_EQ(map.query("occupancy", {3.5, 0.05}).status, Status::kUnknown);
  }
}

TEST(HybridMap, ABeamWithoutReturnShowsNothingWhereTheLaserLosesMuch) {
  HybridMapConfig config = withLayers();
  config.occupancy.clear_range_m = 0.0;
  HybridMap map = mapOver(squareMap(), config);
  const double infinity = std::numeric_limits<double>::infinity();
  ASSERT_TRUE(map.insert(beam({-5.0, 0.05, 0.0}, infinity)).accepted);
  EXPECT_EQ(map.counts().beams, 0U);
  EXPECT_EQ(map.query("occupancy", {-4.0, 0.05}).status, Status::kUnknown);
}

TEST(HybridMap, WritesEachBeamFromWhereItsLaserWasByThen) {
  // At 5 m/s along a wall at y = 4.1, in a turn of 0.1 s: every beam ends on the wall.
  HybridMap map = mapOver(squareMap());
  PosedScan posed = beam({-2.0, 0.05, 0.0}, 1.0);
  posed.scan.angle_min_rad = 0.8;
  posed.scan.angle_increment_rad = 0.05;
  posed.scan.ranges_m.clear();
  for (int i = 0; i < 30; ++i) {
    posed.scan.ranges_m.push_back(
        static_cast<float>(4.05 / std::sin(posed.scan.bearing(std::size_t(i)))));
    posed.scan.T_stamp_beam.push_back({0.5 * i / 30.0, 0.0, 0.0});
  }
  ASSERT_TRUE(map.insert(posed).accepted);
  for (std::size_t i = 0; i < posed.scan.ranges_m.size(); ++i) {
    const double x = -2.0 + posed.scan.T_stamp_beam[i].x_m + 4.05 / std::tan(posed.scan.bearing(i));
    EXPECT_GE(probabilityAt(map, {x, 4.1}), kHit - 1e-6) << x;
  }
  EXPECT_LT(probabilityAt(map, {-1.6, 0.35}), 0.5);  // only late beams, from farther on, pass here
}

TEST(HybridMap, TheLargestRangeIsNoReturnAndNoObstacle) {
  HybridMap at_maximum = mapOver(squareMap()), without_return = mapOver(squareMap());
  const double range_max_m = beam({}, 5.0).scan.range_max_m;
  EXPECT_TRUE(at_maximum.insert(beam({}, range_max_m)).accepted);
  EXPECT_TRUE(without_return.insert(beam({}, double{INFINITY})).accepted);
  EXPECT_EQ(at_maximum.counts().beams, without_return.counts().beams);
  EXPECT_EQ(at_maximum.evidenceInLtrs(0), without_return.evidenceInLtrs(0));
}

TEST(HybridMap, SpreadsASampleOverItsUncertainPlace) {
  HybridMap map = mapOver(squareMap());
  PropertySample sample = salinity({2.0, 3.0}, 35.0);
  sample.covariance = Eigen::Vector2d(0.25, 0.01).asDiagonal();
  ASSERT_TRUE(map.insert(sample).accepted);
  EXPECT_EQ(map.query("salinity", {2.7, 3.0}).status, Status::kKnown);
  EXPECT_EQ(map.query("salinity", {2.0, 3.6}).status, Status::kUnknown);
  EXPECT_NEAR(map.evidenceInLtrs(1), 1.0, 1e-5);
}

TEST(HybridMap, AnswersQueriesForUnknownLayersAndPlaces) {
  const HybridMap map = mapOver(squareMap());
  EXPECT_EQ(map.query("humidity", {0.0, 0.0}).status, Status::kNoSuchLayer);
  EXPECT_EQ(map.query("occupancy", {500.0, 0.0}).status, Status::kOutside);
  EXPECT_EQ(map.query("occupancy", {NAN, 0.0}).status, Status::kOutside);
  EXPECT_EQ(map.query("salinity", {0.0, 0.0}).status, Status::kUnknown);
}

TEST(HybridMap, TellsWhichLayersChanged) {
  HybridMap map = mapOver(squareMap());
  const std::uint64_t before = map.revision();
  EXPECT_TRUE(map.changedSince(before).empty());
  map.insert(salinity({2.0, 1.0}, 35.0));
  const auto changed = map.changedSince(before);
  ASSERT_EQ(changed.size(), 1U);
  EXPECT_EQ(changed[0].layer, 1);
  EXPECT_EQ(changed[0].ltr, map.query("salinity", {2.0, 1.0}).ltr);
  EXPECT_TRUE(map.changedSince(map.revision()).empty());
}

TEST(HybridMap, DescribesItsTopology) {
  const LandmarkMap landmarks = squareMap();
  const HybridMap map = mapOver(landmarks);
  const auto topology = map.topology(landmarks);
  ASSERT_EQ(topology.size(), 2U);
  int shared = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (topology[0].neighbours[k] != topology[1].id) continue;
    ++shared;
    EXPECT_THAT(topology[1].landmark_ids, testing::Contains(topology[0].landmark_ids[k]));
    EXPECT_THAT(topology[1].landmark_ids, testing::Contains(topology[0].landmark_ids[(k + 1) % 3]));
  }
  EXPECT_EQ(shared, 1);
  EXPECT_GT(topology[0].shape_factor, 1.0);
  EXPECT_LT(topology[0].shape_factor, 1.1);
  EXPECT_GE(topology[0].alpha_cells, 100);
}

TEST(HybridMap, PacksWhatIsFarAndUnpacksItWithoutLoss) {
  LandmarkMap landmarks = squareMap();
  HybridMap map = mapOver(landmarks);
  RandomGenerator generator(4);
  for (int i = 0; i < 200; ++i) {
    map.insert(beam({0.0, 0.0, sampleUniform(generator, -3.0, 3.0)}, 6.0));
    map.insert(salinity({sampleUniform(generator, -9, 9), sampleUniform(generator, -9, 9)}, i));
  }
  const auto before = map.renderOccupancy({-12.0, -12.0}, 120, 120, 0.2);
  const double evidence = map.evidenceInLtrs(1);
  const std::size_t unpacked = map.ltrMemory().unpacked_bytes;
  ASSERT_EQ(map.ltrMemory().packed_bytes, 0U);
  for (int i = 0; i < 120; ++i) map.insert(beam({200.0 + 6.0 * i, 0.0, 0.0}, 5.0));
  EXPECT_EQ(map.ltrMemory().unpacked_bytes, 0U);
  EXPECT_EQ(map.ltrMemory().packed_from_bytes, unpacked);
  EXPECT_LT(map.ltrMemory().packed_bytes, unpacked / 5);
  const auto after = map.renderOccupancy({-12.0, -12.0}, 120, 120, 0.2);
  EXPECT_EQ(std::memcmp(before.data(), after.data(), before.size() * sizeof(float)), 0);
  EXPECT_EQ(map.evidenceInLtrs(1), evidence);
  EXPECT_EQ(map.ltrMemory().unpacked_bytes, unpacked);
}

TEST(HybridMap, BeginsAnewAfterAReset) {
  HybridMap map = mapOver(squareMap());
  map.insert(salinity({2.0, 3.0}, 35.0));
  const std::uint64_t before = map.revision();
  map.reset();
  EXPECT_TRUE(map.pinnedLandmarks().empty());
  EXPECT_EQ(map.query("salinity", {2.0, 3.0}).status, Status::kOutside);
  EXPECT_GT(map.revision(), before);
  EXPECT_TRUE(map.apply(squareMap()).accepted);
}

}  // namespace
}  // namespace hymm::core
