#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "common/random.h"
#include "small_maps.h"

namespace hymm::core {
namespace {

using Status = LayerQuery::Status;

TEST(HybridMap, WhatWasWrittenFollowsItsLandmarks) {
  LandmarkMap landmarks = squareMap();
  HybridMap map = mapOver(landmarks);
  map.insert(beam({-5.0, 0.05, 0.0}, 9.1));
  map.insert(salinity({2.0, 3.0}, 35.0));
  const Pose2 correction{30.0, -20.0, 0.8};
  for (auto& landmark : landmarks.landmarks) landmark.position = correction * landmark.position;
  landmarks.version = 2;
  ASSERT_TRUE(map.apply(landmarks).change.retired.empty());
  EXPECT_EQ(map.query("occupancy", {4.0, 0.05}).status, Status::kOutside);
  EXPECT_NEAR(probabilityAt(map, correction * Eigen::Vector2d(4.1, 0.05)), kHit, 1e-6);
  const LayerQuery answer = map.query("salinity", correction * Eigen::Vector2d(2.0, 3.0));
  ASSERT_EQ(answer.status, Status::kKnown);
  EXPECT_NEAR(answer.value->value, 35.0, 1e-5);
}

TEST(HybridMap, ContentOfARetiredLtrMovesToThoseThatCoverItsPlace) {
  // The triangle over the base turns over; what lay near the base is found on the base's other side
  // in no LTR, and waits.
  LandmarkMap landmarks = mapOf({{0.0, 0.0}, {10.0, 0.0}, {5.0, 8.0}, {5.0, -8.0}});
  HybridMap map = mapOver(landmarks);
  ASSERT_EQ(map.partition().mesh().aliveCount(), 2U);
  map.insert(salinity({5.0, 2.0}, 20.0));
  map.insert(salinity({5.0, -2.0}, 30.0));
  landmarks.landmarks[2].position = {5.0, -1.0};
  landmarks.version = 2;
  ASSERT_FALSE(map.apply(landmarks).change.retired.empty());
  EXPECT_NEAR(map.evidenceInLtrs(1) + map.evidenceWaiting(1), 2.0, 1e-5);
}

TEST(HybridMap, LosesNothingWhenAllLandmarksAreRemoved) {
  LandmarkMap landmarks = squareMap();
  HybridMap map = mapOver(landmarks);
  map.insert(salinity({2.0, 3.0}, 35.0));
  LandmarkMap none;
  none.version = 2;
  ASSERT_TRUE(map.apply(none).accepted);
  EXPECT_TRUE(map.pinnedLandmarks().empty());
  EXPECT_NEAR(map.evidenceWaiting(1), 1.0, 1e-5);
  landmarks.version = 3;
  ASSERT_TRUE(map.apply(landmarks).accepted);
  EXPECT_NEAR(map.query("salinity", {2.0, 3.0}).value->value, 35.0, 1e-5);
}

TEST(HybridMap, LosesNothingWhenACorrectionBringsThreeLandmarksIntoLine) {
  LandmarkMap landmarks = mapOf({{0.0, 0.0}, {10.0, 0.0}, {5.0, 8.0}});
  HybridMap map = mapOver(landmarks);
  map.insert(salinity({5.0, 3.0}, 35.0));
  landmarks.landmarks[2].position = {5.0, 0.0};
  landmarks.version = 2;
  EXPECT_EQ(map.apply(landmarks).change.retired.size(), 1U);
  EXPECT_TRUE(map.pinnedLandmarks().empty());
  EXPECT_NEAR(map.evidenceWaiting(1), 1.0, 1e-5);
}

TEST(HybridMap, SurvivesACorrectionOf50Metres) {
  RandomGenerator generator(2);
  LandmarkMap landmarks = jitteredGrid(6, 6, 10.0, generator);
  HybridMap map = mapOver(landmarks);
  for (int i = 0; i < 200; ++i) {
    map.insert(salinity({sampleUniform(generator, 0, 50), sampleUniform(generator, 0, 50)}, 1.0));
  }
  for (auto& landmark : landmarks.landmarks) {
    landmark.position += Eigen::Vector2d(sampleUniform(generator, -50, 50), 50.0);
  }
  landmarks.version = 2;
  ASSERT_FALSE(map.apply(landmarks).change.retired.empty());
  EXPECT_NEAR(map.evidenceInLtrs(1) + map.evidenceWaiting(1), 200.0, 1e-3);
}

TEST(HybridMap, GrowsByAMapThatAnUpdateHasOvertaken) {
  LandmarkMap landmarks = squareMap();
  HybridMap map(withLayers());
  LandmarkUpdate update;
  update.version = 2;
  update.changed = landmarks.landmarks;
  const Pose2 correction{3.0, 2.0, 0.4};
  for (auto& landmark : update.changed) landmark.position = correction * landmark.position;
  ASSERT_TRUE(map.apply(update).accepted);
  update.changed.clear();
  update.removed_ids = {3};
  update.since_version = 2;
  update.version = 3;
  ASSERT_TRUE(map.apply(update).accepted);
  const MapOutcome outcome = map.apply(landmarks);  // version 1
  EXPECT_TRUE(outcome.accepted);
  EXPECT_EQ(outcome.change.created.size(), 1U);
  EXPECT_EQ(map.landmarkVersion(), 3U);
  EXPECT_EQ(map.pinnedLandmarks(), (std::vector<int>{0, 1, 2}));
  EXPECT_NE(map.query("occupancy", correction * Eigen::Vector2d(9.9, -9.8)).status,
            Status::kOutside);
}

/// Lives through a random history with samples and beams: nothing observed is lost.
RC_GTEST_PROP(HybridMap, LosesNoObservationWhateverTheLandmarksDo, ()) {
  RandomGenerator generator(*rc::gen::inRange<std::uint64_t>(0, 1ULL << 40U));
  const auto uniform = [&](double low, double high) { return sampleUniform(generator, low, high); };
  HybridMapConfig config = withLayers();
  config.resolution_m = 0.5;
  // Beams tell of free space alone, and too few to reach the limit: of what contradicts itself, and
  // of what exceeds a limit, some is forgotten.
  config.occupancy.hit_probability = 0.5;
  config.occupancy.min_probability = 0.001;
  HybridMap map(config);
  LandmarkMap landmarks;
  int next_id = 0;
  double samples = 0.0;
  for (int step = 0; step < 8; ++step) {
    const int fresh = static_cast<int>(uniform(0.0, 12.0));
    for (int i = 0; i < fresh; ++i) {
      landmarks.landmarks.push_back(
          landmarkAt(next_id++, {uniform(0.0, 60.0), uniform(0.0, 60.0)}));
    }
    const double size = std::pow(10.0, uniform(-2.0, 1.5));
    for (auto& landmark : landmarks.landmarks) {
      landmark.position += Eigen::Vector2d(uniform(-size, size), uniform(-size, size));
    }
    if (landmarks.landmarks.size() > 2 && uniform(0.0, 1.0) < 0.4) {
      const auto last = landmarks.landmarks.back().id;
      if (uniform(0.0, 1.0) < 0.5) landmarks.merges.push_back({last, landmarks.landmarks[0].id});
      landmarks.landmarks.pop_back();
    }
    ++landmarks.version;
    correlate(landmarks);
    const double log_odds = map.evidenceInLtrs(0) + map.evidenceWaiting(0);
    RC_ASSERT(map.apply(landmarks).accepted);
    const double moved = map.evidenceInLtrs(0) + map.evidenceWaiting(0);
    RC_ASSERT(std::abs(moved - log_odds) <= 1e-3 + 1e-4 * std::abs(log_odds));
    const double kept = map.evidenceInLtrs(2) + map.evidenceWaiting(2);
    RC_ASSERT(std::abs(kept - samples) <= 1e-4 * (1.0 + samples));
    for (int i = 0; i < 20; ++i) {
      PropertySample sample;
      sample.layer = "terrain";
      sample.position = {uniform(-10.0, 70.0), uniform(-10.0, 70.0)};
      sample.covariance = uniform(0.0, 0.5) * Eigen::Matrix2d::Identity();
      sample.sample.value = 1.0;
      sample.sample.label = "grass";
      RC_ASSERT(map.insert(sample).accepted);
      samples += 1.0;
      RC_ASSERT(map.insert(beam({uniform(0.0, 60.0), uniform(0.0, 60.0), uniform(-3.0, 3.0)},
                                uniform(1.0, 40.0), landmarks.version))
                    .accepted);
    }
  }
}

}  // namespace
}  // namespace hymm::core
