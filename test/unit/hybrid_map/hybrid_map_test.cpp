#include "hybrid_map/hybrid_map.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <set>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "common/error.h"
#include "hybrid_map/log_odds.h"
#include "landmark_maps.h"

namespace hymm::core {
namespace {

using Status = LayerQuery::Status;
using testing::HasSubstr;

constexpr const char* kLayers = "salinity gaussian; terrain category grass asphalt";

/// What one beam says of the cell in which it ends.
const double kHit = OccupancyConfig().hit_probability;

HybridMapConfig withLayers() {
  HybridMapConfig config;
  config.layers = kLayers;
  return config;
}

/// A square of 20 m around the origin in two LTRs.
LandmarkMap squareMap() {
  return mapOf({{-10.0, -10.0}, {10.0, -10.0}, {10.0, 10.0}, {-10.5, 10.0}});
}

/// A scan of one beam.
PosedScan beam(const Pose2& T_map_laser, double range_m, std::uint64_t version = 1) {
  PosedScan posed;
  posed.T_map_laser = T_map_laser;
  posed.map_version = version;
  posed.scan.angle_increment_rad = 0.01;
  posed.scan.range_max_m = 80.0;
  posed.scan.ranges_m = {static_cast<float>(range_m)};
  return posed;
}

PropertySample salinity(const Eigen::Vector2d& place, double value) {
  PropertySample sample;
  sample.layer = "salinity";
  sample.position = place;
  sample.sample.value = value;
  sample.sample.variance = 0.01;
  return sample;
}

double probabilityAt(const HybridMap& map, const Eigen::Vector2d& place) {
  const LayerQuery answer = map.query("occupancy", place);
  return answer.value ? answer.value->value : 0.5;
}

HybridMap mapOver(const LandmarkMap& landmarks, const HybridMapConfig& config = withLayers()) {
  HybridMap map(config);
  EXPECT_TRUE(map.apply(landmarks).accepted);
  return map;
}

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

TEST(HybridMap, ABeamWithoutReturnIsFreeAsFarAsBeamsAreWritten) {
  HybridMapConfig config = withLayers();
  config.occupancy.range_m = 8.0;
  HybridMap map = mapOver(squareMap(), config);
  map.insert(beam({-5.0, 0.05, 0.0}, std::numeric_limits<double>::infinity()));
  EXPECT_LT(probabilityAt(map, {2.9, 0.05}), 0.5);
  EXPECT_EQ(map.query("occupancy", {3.5, 0.05}).status, Status::kUnknown);
}

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

/// A map without LTRs over two pairs of landmarks, 40 m apart.
struct TwoSheets {
  TwoSheets() : map(withoutLtrs()) { map.apply(landmarks); }

  static HybridMapConfig withoutLtrs() {
    HybridMapConfig config = withLayers();
    config.partition.min_observations = 1000;
    return config;
  }
  void tellAgain() {
    ++landmarks.version;
    ASSERT_TRUE(map.apply(landmarks).accepted);
  }
  /// From between the landmarks of one pair, a beam towards the other.
  void lookRight() { map.insert(beam({6.0, 5.0, 0.0}, 22.0, landmarks.version)); }
  void lookLeft() { map.insert(beam({46.0, 5.0, M_PI}, 22.0, landmarks.version)); }

  /// Sheets that know the occupancy of a place.
  int sheetsAt(const Eigen::Vector2d& place) const {
    int count = 0;
    map.waiting().visitTiles(LayerSet::kOccupancy, [&](const WaitingTile& tile) {
      const Eigen::Array2i cell =
          ((inverse(tile.T_map_cells) * place) / tile.resolution_m).array().floor().cast<int>();
      if ((cell < 0).any() || (cell >= WaitingTile::kCells).any()) return;
      const int index = cell.y() * WaitingTile::kCells + cell.x();
      if (*tile.cells->read(map.layers(), LayerSet::kOccupancy, index) != 0.0F) ++count;
    });
    return count;
  }

  LandmarkMap landmarks = mapOf({{0.0, 0.0}, {12.0, 0.0}, {40.0, 0.0}, {52.0, 0.0}});
  HybridMap map;
};

TEST(HybridMap, WhatTwoSheetsSawOfOnePlaceComesTogether) {
  TwoSheets two;
  two.lookRight();
  two.lookLeft();
  two.map.insert(beam({100.0, 100.0, 0.0}, 2.0));
  // Both saw from x = 24 m to x = 28 m; halfway lies x = 26 m.
  ASSERT_EQ(two.sheetsAt({24.9, 5.0}), 2);
  ASSERT_EQ(two.sheetsAt({27.1, 5.0}), 2);
  const double before = two.map.evidenceWaiting(0);
  two.tellAgain();
  EXPECT_EQ(two.sheetsAt({24.9, 5.0}), 1);
  EXPECT_EQ(two.sheetsAt({27.1, 5.0}), 1);
  EXPECT_EQ(two.sheetsAt({26.0, 5.0}), 2);  // the seam
  EXPECT_NEAR(two.map.evidenceWaiting(0), before, 1e-4);
}

TEST(HybridMap, SheetsThatAreNotCertainOfEachOtherStayApart) {
  TwoSheets two;
  two.landmarks.cross_covariances.pop_back();  // of 40 m and 52 m
  for (auto& pair : two.landmarks.cross_covariances) pair.block *= 0.0;
  for (auto& landmark : two.landmarks.landmarks) landmark.covariance *= 4.0;
  two.lookRight();
  two.lookLeft();
  two.map.insert(beam({100.0, 100.0, 0.0}, 2.0));
  two.tellAgain();
  EXPECT_EQ(two.sheetsAt({24.9, 5.0}), 2);
}

TEST(HybridMap, ASheetIsWrittenOnWhereverItIsNear) {
  HybridMap map(TwoSheets::withoutLtrs());
  map.apply(mapOf({{0.0, 0.0}, {12.0, 0.0}, {6.0, 12.0}, {18.0, 12.0}}));
  // On the way back other landmarks are nearer than those by which the way there was kept.
  for (const double y : {-4.0, 15.0}) map.insert(beam({9.0, y, 0.0}, 5.0));
  std::set<std::uint64_t> sheets;
  map.waiting().visitTiles(LayerSet::kOccupancy,
                           [&](const WaitingTile& tile) { sheets.insert(tile.sheet); });
  EXPECT_EQ(sheets.size(), 1U);
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

TEST(HybridMap, SpreadsASampleOverItsUncertainPlace) {
  HybridMap map = mapOver(squareMap());
  PropertySample sample = salinity({2.0, 3.0}, 35.0);
  sample.covariance = Eigen::Vector2d(0.25, 0.01).asDiagonal();
  ASSERT_TRUE(map.insert(sample).accepted);
  EXPECT_EQ(map.query("salinity", {2.7, 3.0}).status, Status::kKnown);
  EXPECT_EQ(map.query("salinity", {2.0, 3.6}).status, Status::kUnknown);
  EXPECT_NEAR(map.evidenceInLtrs(1), 1.0, 1e-5);
}

TEST(HybridMap, RefusesSamplesThatItCannotPlaceAndSaysWhy) {
  HybridMap map = mapOver(squareMap());
  PropertySample sample = salinity({2.0, 3.0}, 35.0);
  sample.covariance = 1e6 * Eigen::Matrix2d::Identity();
  EXPECT_THAT(map.insert(sample).reason, HasSubstr("uncertain by 1000 m"));
  sample.covariance << 1.0, 2.0, 2.0, 1.0;
  EXPECT_THAT(map.insert(sample).reason, HasSubstr("semi-definite"));
  sample = salinity({NAN, 0.0}, 1.0);
  EXPECT_THAT(map.insert(sample).reason, HasSubstr("not finite"));
  sample = salinity({2.0, 3.0}, 35.0);
  sample.layer = "humidity";
  EXPECT_THAT(map.insert(sample).reason, HasSubstr("no layer 'humidity'; there are 'occupancy'"));
  sample.layer = "terrain";
  sample.sample.label = "snow";
  EXPECT_THAT(map.insert(sample).reason, HasSubstr("no category 'snow'"));
  sample.layer = "occupancy";
  EXPECT_FALSE(map.insert(sample).accepted);
  EXPECT_EQ(map.counts().refused_samples, 6U);
  EXPECT_EQ(map.evidenceInLtrs(1) + map.evidenceInLtrs(2), 0.0);
}

TEST(HybridMap, RefusesScansThatItCannotPlaceAndSaysWhy) {
  HybridMap map = mapOver(squareMap());
  EXPECT_THAT(map.insert(beam({}, 5.0, 2)).reason, HasSubstr("version 2"));
  EXPECT_THAT(map.insert(beam({NAN, 0.0, 0.0}, 5.0)).reason, HasSubstr("not finite"));
  PosedScan uncertain = beam({}, 5.0);
  uncertain.pose_deviation_m = 3.0;
  EXPECT_THAT(map.insert(uncertain).reason, HasSubstr("not certain enough"));
  uncertain.pose_deviation_m = NAN;
  EXPECT_FALSE(map.insert(uncertain).accepted);
  PosedScan empty = beam({}, 5.0);
  empty.scan.ranges_m.clear();
  EXPECT_FALSE(map.insert(empty).accepted);
  EXPECT_EQ(map.counts().refused_scans, 5U);
  EXPECT_EQ(map.evidenceInLtrs(0), 0.0);
}

TEST(HybridMap, SkipsBeamsThatMeasuredNothing) {
  HybridMap map = mapOver(squareMap());
  for (const double range : {double{NAN}, double{-INFINITY}, -1.0, 100.0}) {
    EXPECT_TRUE(map.insert(beam({}, range)).accepted);
  }
  EXPECT_EQ(map.counts().beams, 0U);
}

TEST(HybridMap, TheLargestRangeIsNoReturnAndNoObstacle) {
  HybridMap at_maximum = mapOver(squareMap()), without_return = mapOver(squareMap());
  const double range_max_m = beam({}, 5.0).scan.range_max_m;
  EXPECT_TRUE(at_maximum.insert(beam({}, range_max_m)).accepted);
  EXPECT_TRUE(without_return.insert(beam({}, double{INFINITY})).accepted);
  EXPECT_EQ(at_maximum.counts().beams, without_return.counts().beams);
  EXPECT_EQ(at_maximum.evidenceInLtrs(0), without_return.evidenceInLtrs(0));
}

TEST(HybridMap, RefusesLandmarksThatAreNotFiniteOrOld) {
  LandmarkMap landmarks = squareMap();
  landmarks.version = 5;
  HybridMap map = mapOver(landmarks);
  const std::vector<int> pinned = map.pinnedLandmarks();
  landmarks.version = 6;
  landmarks.landmarks[2].position.x() = INFINITY;
  EXPECT_THAT(map.apply(landmarks).reason, HasSubstr("landmark 2"));
  landmarks = squareMap();
  landmarks.version = 6;
  landmarks.landmarks[1].id = 0;
  EXPECT_THAT(map.apply(landmarks).reason, HasSubstr("ascending"));
  LandmarkUpdate update;
  update.since_version = 9;
  update.version = 10;
  EXPECT_THAT(map.apply(update).reason, HasSubstr("a whole map is needed"));
  update.since_version = 3;
  update.version = 4;
  EXPECT_THAT(map.apply(update).reason, HasSubstr("version 4"));
  EXPECT_EQ(map.pinnedLandmarks(), pinned);
  EXPECT_EQ(map.landmarkVersion(), 5U);
  EXPECT_EQ(map.counts().refused_landmarks, 4U);
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

TEST(HybridMap, RefusesAResolutionThatNeedsMoreMemoryThanAllowed) {
  HybridMapConfig config = withLayers();
  config.resolution_m = 0.02;
  try {
    const HybridMap map(config);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("MB within active_radius_m"));
    EXPECT_THAT(error.what(), HasSubstr(std::to_string(int(std::ceil(config.activeMemory_mb())))));
  }
}

TEST(HybridMap, RefusesEverythingThatIsWrongWithAConfigurationAtOnce) {
  HybridMapConfig config;
  config.resolution_m = -1.0;
  config.layers = "height gausian";
  config.partition.max_stretch = 0.5;
  try {
    const HybridMap map(config);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.problems().size(), 3U);
  }
}

TEST(HybridMap, DropsTheOldestThatWaitsWhenMemoryIsShortAndCountsIt) {
  HybridMapConfig config = withLayers();
  config.waiting.max_memory_mb = 0.02;  // one tile of salinity
  HybridMap map(config);
  map.insert(salinity({0.0, 0.0}, 1.0));
  map.insert(salinity({50.0, 0.0}, 1.0));
  EXPECT_EQ(map.counts().dropped_waiting_tiles, 1U);
  EXPECT_EQ(map.evidenceWaiting(1), 1.0);
  EXPECT_LE(map.waitingMemory().bytes(), 20000U);
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

/// Lives through a random history with samples and beams: nothing observed is lost.
RC_GTEST_PROP(HybridMap, LosesNoObservationWhateverTheLandmarksDo, ()) {
  RandomGenerator generator(*rc::gen::inRange<std::uint64_t>(0, 1ULL << 40U));
  const auto uniform = [&](double low, double high) { return sampleUniform(generator, low, high); };
  HybridMapConfig config = withLayers();
  config.resolution_m = 0.5;
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

TEST(HybridMap, RefusesAScanWhoseMotionIsNotKnownForAllBeams) {
  HybridMap map = mapOver(squareMap());
  PosedScan posed = beam({-5.0, 0.05, 0.0}, 9.1);
  posed.scan.T_stamp_beam.resize(2);
  const MapOutcome outcome = map.insert(posed);
  EXPECT_FALSE(outcome.accepted);
  EXPECT_THAT(outcome.reason, HasSubstr("motion is known for 2 of 1 beams"));
}

}  // namespace
}  // namespace hymm::core
