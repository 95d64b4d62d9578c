#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "common/error.h"
#include "small_maps.h"

namespace hymm::core {
namespace {

using testing::HasSubstr;

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

TEST(HybridMap, ASampleThatACellCannotHoldIsRefusedAndHarmsNothing) {
  HybridMap map = mapOver(squareMap());
  map.insert(salinity({2.0, 3.0}, 35.0));
  EXPECT_THAT(map.insert(salinity({2.0, 3.0}, 1e39)).reason, HasSubstr("a cell cannot hold"));
  PropertySample terrain = salinity({2.0, 3.0}, 1e39);
  terrain.layer = "terrain";
  terrain.sample.label = "grass";
  EXPECT_THAT(map.insert(terrain).reason, HasSubstr("which a cell can hold"));
  EXPECT_EQ(map.counts().refused_samples, 2U);
  EXPECT_EQ(map.query("salinity", {2.0, 3.0}).value->value, 35.0);
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

TEST(HybridMap, RefusesAScanWhoseMotionIsNotKnownForAllBeams) {
  HybridMap map = mapOver(squareMap());
  PosedScan posed = beam({-5.0, 0.05, 0.0}, 9.1);
  posed.scan.T_stamp_beam.resize(2);
  const MapOutcome outcome = map.insert(posed);
  EXPECT_FALSE(outcome.accepted);
  EXPECT_THAT(outcome.reason, HasSubstr("motion is known for 2 of 1 beams"));
}

TEST(HybridMap, SkipsBeamsThatMeasuredNothing) {
  HybridMap map = mapOver(squareMap());
  for (const double range : {double{NAN}, double{-INFINITY}, -1.0, 100.0}) {
    EXPECT_TRUE(map.insert(beam({}, range)).accepted);
  }
  EXPECT_EQ(map.counts().beams, 0U);
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

TEST(HybridMap, RefusesARangeOfWhichOneScanDoesNotFitWhatMayWait) {
  HybridMapConfig config;
  config.resolution_m = 0.05;
  config.occupancy.range_m = 120.0;
  try {
    const HybridMap map(config);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    // A disc of 120 m has 17 672 tiles of 1.6 m with 1024 cells of 8 1/8 bytes: 147 MB, and its
    // rim.
    EXPECT_THAT(error.what(), HasSubstr("occupancy.range_m: one scan up to 120 m needs 153 MB"));
    EXPECT_THAT(error.what(), HasSubstr("more than waiting.max_memory_mb = 64"));
  }
  config.waiting.max_memory_mb = 153.0;
  EXPECT_TRUE(config.problems().empty());
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

}  // namespace
}  // namespace hymm::core
