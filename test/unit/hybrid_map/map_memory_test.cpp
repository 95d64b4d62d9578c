#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "hybrid_map/hybrid_map.h"
#include "landmark_maps.h"

/// What compression keeps, and that the memory stays within its limit on a long drive.
namespace hymm::core {
namespace {

constexpr double kSpacing_m = 20.0, kStep_m = 2.0;

/// Along a road, on both of its sides.
LandmarkMap roadMap(double length_m) {
  std::vector<Eigen::Vector2d> places;
  for (double x = 0.0; x <= length_m; x += kSpacing_m) {
    places.emplace_back(x, -10.0);
    places.emplace_back(x + 1.0, 10.0);
  }
  return mapOf(places);
}

HybridMapConfig configOf(const std::string& form, double max_memory_mb) {
  HybridMapConfig config;
  config.active_radius_m = 20.0;
  config.compression.form = form;
  config.max_memory_mb = max_memory_mb;
  return config;
}

/// Between hedges, whose branches scatter the ranges.
PosedScan hedges(double x, RandomGenerator& generator) {
  PosedScan posed;
  posed.T_map_laser = {x, 0.0, 0.0};
  posed.map_version = 1;
  posed.scan.angle_min_rad = -1.5;
  posed.scan.angle_increment_rad = 0.03;
  posed.scan.range_max_m = 80.0;
  for (int i = 0; i <= 100; ++i) {
    const double to_hedge =
        7.0 / std::max(0.3, std::abs(std::sin(posed.scan.bearing(std::size_t(i)))));
    posed.scan.ranges_m.push_back(static_cast<float>(to_hedge + sampleNormal(generator, 1.0)));
  }
  return posed;
}

PropertySample salinityAt(double x) {
  PropertySample sample;
  sample.layer = "salinity";
  sample.position = {x, 1.0};
  sample.sample.value = 35.0;
  sample.sample.variance = 0.01;
  return sample;
}

/// Drives from `from` to `to`; returns the most memory that LTRs ever took, in MB.
double drive(HybridMap& map, double from, double to) {
  RandomGenerator generator(5);
  double most_mb = 0.0;
  for (double x = from; x < to; x += kStep_m) {
    EXPECT_TRUE(map.insert(hedges(x, generator)).accepted);
    most_mb = std::max(most_mb, 1e-6 * static_cast<double>(map.ltrMemory().bytes()));
  }
  return most_mb;
}

TEST(MapMemory, StaysWithinItsLimitOnALongDriveAndTellsWhatItForgot) {
  const HybridMapConfig config = configOf("lossless", 2.0);
  ASSERT_LT(config.activeMemory_mb(), config.max_memory_mb);
  HybridMap map(config);
  ASSERT_TRUE(map.apply(roadMap(6000.0)).accepted);
  EXPECT_LE(drive(map, 0.0, 500.0), config.max_memory_mb);
  EXPECT_EQ(map.counts().forgotten_ltrs, 0U);
  ASSERT_EQ(map.query("occupancy", {200.0, 0.5}).status, LayerQuery::Status::kKnown);
  EXPECT_LE(drive(map, 500.0, 6000.0), config.max_memory_mb);
  EXPECT_GT(map.counts().forgotten_ltrs, 0U);
  // The oldest first; what is near is still known.
  EXPECT_EQ(map.query("occupancy", {200.0, 0.5}).status, LayerQuery::Status::kUnknown);
  EXPECT_EQ(map.query("occupancy", {5900.0, 0.5}).status, LayerQuery::Status::kKnown);
  EXPECT_NE(map.partition().mesh().locate({200.0, 0.5}), kNone);
}

TEST(MapMemory, ToReadersAForgottenLtrHasChanged) {
  HybridMap map(configOf("lossless", 2.0));
  ASSERT_TRUE(map.apply(roadMap(6000.0)).accepted);
  drive(map, 0.0, 500.0);
  const std::uint64_t revision = map.revision();
  const int first = map.partition().mesh().locate({200.0, 0.5});
  drive(map, 500.0, 6000.0);
  const std::vector<ChangedLayer> changed = map.changedSince(revision);
  EXPECT_THAT(changed, testing::Contains(testing::Field(&ChangedLayer::ltr, first)));
}

TEST(MapMemory, WhatIsLookedAtAfarIsCompressedAgainThoughTheVehicleStands) {
  HybridMap map(configOf("lossless", 100.0));
  ASSERT_TRUE(map.apply(roadMap(1000.0)).accepted);
  drive(map, 0.0, 1000.0);
  const std::size_t packed = map.ltrMemory().packed_from_bytes;
  for (double x = 0.0; x < 900.0; x += 1.0) map.query("occupancy", {x, 0.5});
  ASSERT_LT(map.ltrMemory().packed_from_bytes, packed / 2);
  RandomGenerator generator(6);
  for (int i = 0; i < 250; ++i) map.insert(hedges(1000.0, generator));
  EXPECT_GE(map.ltrMemory().packed_from_bytes, packed);
}

TEST(MapMemory, LossyCompressionKeepsWhatIsOccupiedFreeAndUnknownAndEveryOtherLayer) {
  HybridMapConfig config = configOf("lossless", 100.0);
  config.layers = "salinity gaussian";
  HybridMap exact(config);
  config.compression.form = "lossy";
  HybridMap lossy(config);
  for (HybridMap* map : {&exact, &lossy}) {
    ASSERT_TRUE(map->apply(roadMap(1000.0)).accepted);
    ASSERT_TRUE(map->insert(salinityAt(30.0)).accepted);
    drive(*map, 0.0, 1000.0);
  }
  EXPECT_LT(lossy.ltrMemory().packed_bytes, exact.ltrMemory().packed_bytes / 3);
  const Eigen::Vector2d low(0.0, -9.0);
  const std::vector<float> was = exact.renderOccupancy(low, 3000, 90, 0.2);
  const std::vector<float> is = lossy.renderOccupancy(low, 3000, 90, 0.2);
  const auto threshold = std::log(0.65F / 0.35F);
  for (std::size_t i = 0; i < was.size(); ++i) {
    ASSERT_EQ(std::isnan(is[i]), std::isnan(was[i]));
    if (std::isnan(was[i])) continue;
    ASSERT_EQ(is[i] > threshold, was[i] > threshold);
  }
  const LayerQuery salinity = lossy.query("salinity", {30.0, 1.0});
  ASSERT_TRUE(salinity.value.has_value());
  EXPECT_NEAR(salinity.value->value, 35.0, 1e-5);
}

TEST(MapMemory, RefusesAThresholdThatNoCellReaches) {
  HybridMapConfig config = configOf("lossy", 100.0);
  config.compression.occupied_probability = 0.98;
  try {
    const HybridMap map(config);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("no cell would stay occupied"));
  }
}

}  // namespace
}  // namespace hymm::core
