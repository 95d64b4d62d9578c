#include "information_map/sight_map.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "common/random.h"
#include "dense_images.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;
using testing::IsEmpty;
using testing::SizeIs;

TEST(SightMap, HidesWhatIsBehindAWall) {
  OccupancyImage image = freeImage(-10.0, -10.0, 10.0, 10.0);
  fillBox(image, 3.0, -2.0, 3.4, 2.0);
  const SightMap sight({}, image);
  EXPECT_TRUE(sight.hides({0.0, 0.0}, {8.0, 0.5}));
  EXPECT_TRUE(sight.hides({8.0, 0.5}, {0.0, 0.0}));
  EXPECT_FALSE(sight.hides({0.0, 0.0}, {2.5, 0.0}));  // before the wall
  EXPECT_FALSE(sight.hides({0.0, 4.0}, {8.0, 4.0}));  // past its end
}

TEST(SightMap, TakesWhatIsNearALandmarkForTheLandmark) {
  OccupancyImage image = freeImage(-10.0, -10.0, 10.0, 10.0);
  fillBox(image, 4.6, -0.4, 5.4, 0.4);  // a trunk of 0.8 m at (5, 0)
  DenseMapConfig config;
  config.landmark_clearance_m = 0.7;
  EXPECT_FALSE(SightMap(config, image).hides({0.0, 0.0}, {5.0, 0.0}));
  EXPECT_TRUE(SightMap(config, image).hides({0.0, 0.0}, {7.0, 0.0}));
  config.landmark_clearance_m = 0.2;
  EXPECT_TRUE(SightMap(config, image).hides({0.0, 0.0}, {5.0, 0.0}));
}

TEST(SightMap, UnknownHidesNothing) {
  const OccupancyImage image = unknownImage(-10.0, -10.0, 10.0, 10.0);
  EXPECT_FALSE(SightMap({}, image).hides({-5.0, 0.0}, {5.0, 0.0}));
  EXPECT_FALSE(SightMap({}, image).hides({-500.0, 0.0}, {500.0, 3.0}));
  EXPECT_FALSE(SightMap({}, image).hides({1e12, 0.0}, {1e12 + 5.0, 0.0}));
  EXPECT_TRUE(SightMap({}, image).isFree({0.0, -1e300}, 1.0));
}

RC_GTEST_PROP(SightMap, MeetsEveryCellOnTheLine, ()) {
  RandomGenerator generator(*rc::gen::arbitrary<std::uint32_t>());
  const auto draw = [&] { return sampleUniform(generator, -6.0, 6.0); };
  OccupancyImage image = freeImage(-5.0, -5.0, 5.0, 5.0);
  const Vector2d low(draw(), draw());
  fillBox(image, low.x(), low.y(), low.x() + 0.7, low.y() + 0.7);
  DenseMapConfig config;
  config.landmark_clearance_m = 0.0;
  const SightMap sight(config, image);
  const Vector2d from(draw(), draw()), to(draw(), draw());
  bool meets = false;
  constexpr int kSamples = 20000;
  for (int i = 0; i <= kSamples && !meets; ++i) {
    const Vector2d at = from + (to - from) * (static_cast<double>(i) / kSamples);
    meets = isOccupied(image, at);
  }
  // A line may cut a corner between two samples, but never the other way round.
  RC_ASSERT(!meets || sight.hides(from, to));
  // Grown by less than the samples' spacing, the box is met if the line passes it at all.
  RC_ASSERT(!sight.hides(from, to) || passesNearOccupied(image, from, to, 1e-3));
}

TEST(SightMap, IsFreeOnlyWithRoomForTheVehicle) {
  OccupancyImage image = freeImage(-10.0, -10.0, 10.0, 10.0);
  fillBox(image, 3.0, -9.0, 3.2, 9.0);
  const SightMap sight({}, image);
  EXPECT_TRUE(sight.isFree({1.9, 0.1}, 1.0));
  EXPECT_FALSE(sight.isFree({2.3, 0.1}, 1.0));
  EXPECT_TRUE(sight.isFree({2.3, 0.1}, 0.5));
}

TEST(SightMap, UnknownIsFreeByConfiguration) {
  DenseMapConfig config;
  const OccupancyImage image = freeImage(-10.0, -10.0, 10.0, 10.0);
  EXPECT_TRUE(SightMap(config, image).isFree({10.5, 0.0}, 1.0));
  config.unknown_is_free = false;
  EXPECT_FALSE(SightMap(config, image).isFree({9.5, 0.0}, 1.0));
  EXPECT_TRUE(SightMap(config, image).isFree({8.5, 0.0}, 1.0));
}

TEST(SightMap, TellsWhatIsOccupiedUnlikeAnother) {
  OccupancyImage image = freeImage(-2.0, -2.0, 2.0, 2.0);
  fillBox(image, 0.1, 0.1, 0.3, 0.3);
  const SightMap before({}, image);
  EXPECT_THAT(before.occupiedUnlike(nullptr), SizeIs(4));
  EXPECT_THAT(before.occupiedUnlike(&before), IsEmpty());
  OccupancyImage grown = freeImage(-6.0, -2.0, 2.0, 2.0);
  fillBox(grown, 0.1, 0.1, 0.1, 0.3);
  fillBox(grown, -5.1, 0.1, -5.1, 0.1);
  const SightMap now({}, grown);
  ASSERT_THAT(now.occupiedUnlike(&before), SizeIs(1));
  EXPECT_NEAR((now.occupiedUnlike(&before)[0] - Vector2d(-5.1, 0.1)).norm(), 0.0, 1e-12);
  EXPECT_THAT(before.occupiedUnlike(&now), SizeIs(2));
}

}  // namespace
}  // namespace hymm::core
