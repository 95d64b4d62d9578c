#include "ros/information_conversions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hymm {
namespace {

using testing::SizeIs;

core::LevelSets twoSquares() {
  core::LevelSets sets;
  sets.map_version = sets.computed_version = 7;
  sets.time_s = 12.5;
  sets.resolution_m = 0.1;
  core::LevelSet set;
  set.value = 25.0;
  set.area_m2 = 0.05;
  set.leaves = {{{0.1, 0.1}, 0.2, 3}, {{0.25, 0.05}, 0.1, 3}};
  set.islands = {{3, 5, {0, 0}}};
  set.vehicle_island = 3;
  sets.sets = {set};
  return sets;
}

TEST(LevelSetMessage, ComesBackAsItWas) {
  const core::LevelSets sets = twoSquares();
  const LevelSet message = toMessage(sets, sets.sets[0], true, "map");
  EXPECT_EQ(message.map_version, 7U);
  EXPECT_TRUE(message.complete);
  EXPECT_NEAR(static_cast<double>(message.islands.at(0).area), 0.05, 1e-6);
  const core::LevelSet back = fromMessage(message);
  ASSERT_THAT(back.leaves, SizeIs(2));
  for (std::size_t i = 0; i < 2; ++i) {
    const core::LevelLeaf& leaf = sets.sets[0].leaves[i];
    EXPECT_NEAR((back.leaves[i].centre - leaf.centre).norm(), 0.0, 1e-12);
    EXPECT_NEAR(back.leaves[i].edge_m, leaf.edge_m, 1e-12);
    EXPECT_EQ(back.leaves[i].island, 3);
  }
}

TEST(LevelSetMessage, IsNotCompleteWhereItOnlyMovedAlong) {
  core::LevelSets sets = twoSquares();
  sets.map_version = 8;
  EXPECT_FALSE(toMessage(sets, sets.sets[0], true, "map").complete);
}

TEST(IslandMarkers, DrawTheBorderOnly) {
  const auto markers = islandMarkers(twoSquares(), "map").markers;
  ASSERT_THAT(markers, SizeIs(3));  // clear, border, the island's id
  // Five squares, of which the four of the first leaf touch the fifth at one side: 10 sides.
  EXPECT_THAT(markers[1].points, SizeIs(20));
  EXPECT_EQ(markers[2].text, "3");
}

}  // namespace
}  // namespace hymm
