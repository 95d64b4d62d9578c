#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "common/error.h"
#include "simulation/world_catalog.h"

namespace hymm::core {
namespace {

World orchard(int landmarks, std::uint64_t seed = 1) {
  WorldConfig config;
  config.name = "orchard";
  config.landmarks = landmarks;
  RandomGenerator generator(seed);
  return makeWorld(config, simulatedCar(), generator);
}

TEST(Orchard, StandsInRowsOnBothSidesOfEachTrack) {
  const World world = orchard(0);
  ASSERT_EQ(world.landmarks.size(), 160U);
  for (const TrueLandmark& tree : world.landmarks) {
    const double from_row = std::abs(std::remainder(tree.position.y() - 3.0, 6.0));
    EXPECT_LT(from_row, 0.5) << "five deviations of the places in a row";
  }
}

TEST(Orchard, LeavesGaps) {
  // A tree is missing where its neighbours in the row are two pitches apart.
  World world = orchard(0);
  std::sort(world.landmarks.begin(), world.landmarks.end(), [](const auto& a, const auto& b) {
    const double row_a = std::round(a.position.y() / 3.0), row_b = std::round(b.position.y() / 3.0);
    return row_a != row_b ? row_a < row_b : a.position.x() < b.position.x();
  });
  int gaps = 0;
  for (std::size_t i = 1; i < world.landmarks.size(); ++i) {
    const Eigen::Vector2d apart = world.landmarks[i].position - world.landmarks[i - 1].position;
    if (std::abs(apart.y()) < 1.5 && apart.x() > 6.0) ++gaps;
  }
  EXPECT_GT(gaps, 0);
}

TEST(Orchard, GrowsInBothDirectionsWithItsTrees) {
  for (const int count : {12, 90, 500, 2000}) {
    const World world = orchard(count);
    EXPECT_EQ(world.landmarks.size(), static_cast<std::size_t>(count));
    Eigen::AlignedBox2d bounds;
    for (const TrueLandmark& tree : world.landmarks) bounds.extend(tree.position);
    const double ratio = bounds.sizes().x() / bounds.sizes().y();
    EXPECT_GT(ratio, 0.4) << count;
    EXPECT_LT(ratio, 2.0) << count;
  }
}

TEST(Orchard, RefusesToBeOfNoRows) { EXPECT_THROW(orchard(5), ConfigError); }

}  // namespace
}  // namespace hymm::core
