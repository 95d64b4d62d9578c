#include "information_map/level_islands.h"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "common/random.h"
#include "information_map/level_quadtree.h"

namespace hymm::core {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

void fill(LevelLattice& lattice, Cell low, Cell high, int level) {
  for (std::int32_t y = low.y; y < high.y; ++y) {
    for (std::int32_t x = low.x; x < high.x; ++x) lattice.set({x, y}, level);
  }
}

TEST(LevelIslands, ConnectsOverSidesNotCorners) {
  LevelLattice lattice(1.0, 1);
  fill(lattice, {-20, -20}, {0, 0}, 1);
  fill(lattice, {0, 0}, {5, 5}, 1);
  LevelIslands islands(1);
  islands.update(lattice);
  ASSERT_THAT(islands.islands(), SizeIs(2));
  EXPECT_EQ(islands.islands()[0].cells, 400U);
  lattice.set({0, -1}, 1);
  islands.update(lattice);
  EXPECT_THAT(islands.islands(), SizeIs(1));
}

TEST(LevelIslands, FollowsAWindingIslandThroughTiles) {
  LevelLattice lattice(1.0, 1);
  for (std::int32_t y = 0; y < 60; ++y) {  // a comb, connected at alternate ends
    if (y % 2 == 0) fill(lattice, {0, y}, {50, y + 1}, 1);
    if (y % 4 == 1) lattice.set({49, y}, 1);
    if (y % 4 == 3) lattice.set({0, y}, 1);
  }
  LevelIslands islands(1);
  islands.update(lattice);
  ASSERT_THAT(islands.islands(), SizeIs(1));
  EXPECT_EQ(islands.islands()[0].cells, lattice.cellsReaching(1));
}

TEST(LevelIslands, KeepsIdsThroughGrowthSplitAndJoin) {
  LevelLattice lattice(1.0, 1);
  fill(lattice, {0, 0}, {30, 4}, 1);
  LevelIslands islands(1);
  islands.update(lattice);
  const int id = islands.islands()[0].id;
  fill(lattice, {0, 4}, {30, 8}, 1);  // grows
  islands.update(lattice);
  EXPECT_EQ(islands.islands()[0].id, id);

  fill(lattice, {10, 0}, {12, 8}, 0);  // falls apart
  islands.update(lattice);
  ASSERT_THAT(islands.islands(), SizeIs(2));
  EXPECT_EQ(islands.islandOf(lattice, {20, 0}), id);
  const int part = islands.islandOf(lattice, {0, 0});
  EXPECT_NE(part, id);
  EXPECT_THAT(islands.joined(), IsEmpty());

  fill(lattice, {10, 0}, {12, 8}, 1);  // joins again
  islands.update(lattice);
  ASSERT_THAT(islands.islands(), SizeIs(1));
  EXPECT_EQ(islands.islands()[0].id, id);
  ASSERT_THAT(islands.joined(), SizeIs(1));
  EXPECT_EQ(islands.joined()[0].id, part);

  fill(lattice, {100, 0}, {102, 2}, 1);  // a new one never gets an old id
  islands.update(lattice);
  EXPECT_GT(islands.islandOf(lattice, {100, 0}), part);
}

TEST(LevelIslands, IgnoresLowerLevels) {
  LevelLattice lattice(1.0, 2);
  fill(lattice, {0, 0}, {10, 10}, 1);
  lattice.set({5, 5}, 2);
  LevelIslands islands(2);
  islands.update(lattice);
  ASSERT_THAT(islands.islands(), SizeIs(1));
  EXPECT_EQ(islands.islands()[0].cells, 1U);
  EXPECT_EQ(islands.islandOf(lattice, {4, 5}), -1);
}

RC_GTEST_PROP(LevelQuadtree, CoversTheSetOnce, ()) {
  RandomGenerator generator(*rc::gen::arbitrary<std::uint32_t>());
  LevelLattice lattice(0.5, 1);
  for (int i = 0; i < 6; ++i) {
    const Cell low{static_cast<std::int32_t>(sampleUniform(generator, -80, 80)),
                   static_cast<std::int32_t>(sampleUniform(generator, -80, 80))};
    fill(lattice, low,
         {low.x + static_cast<std::int32_t>(sampleUniform(generator, 1, 70)),
          low.y + static_cast<std::int32_t>(sampleUniform(generator, 1, 70))},
         generator() % 4 == 0 ? 0 : 1);
  }
  LevelIslands islands(1);
  islands.update(lattice);
  const auto leaves = quadtreeLeaves(lattice, 1, islands);
  std::set<std::pair<std::int32_t, std::int32_t>> covered;
  for (const LevelLeaf& leaf : leaves) {
    const auto edge = static_cast<std::int32_t>(std::lround(leaf.edge_m / 0.5));
    const Cell low = lattice.cellAt(leaf.centre.array() - 0.5 * leaf.edge_m + 0.25);
    for (std::int32_t y = low.y; y < low.y + edge; ++y) {
      for (std::int32_t x = low.x; x < low.x + edge; ++x) {
        RC_ASSERT(lattice.level({x, y}) == 1);
        RC_ASSERT(covered.insert({x, y}).second);
        RC_ASSERT(islands.islandOf(lattice, {x, y}) == leaf.island);
      }
    }
  }
  RC_ASSERT(covered.size() == lattice.cellsReaching(1));
}

TEST(LevelQuadtree, MakesOneLeafOfAnAlignedSquare) {
  LevelLattice lattice(1.0, 1);
  fill(lattice, {-64, 64}, {0, 128}, 1);
  LevelIslands islands(1);
  islands.update(lattice);
  const auto leaves = quadtreeLeaves(lattice, 1, islands);
  ASSERT_THAT(leaves, SizeIs(1));
  EXPECT_EQ(leaves[0].edge_m, 64.0);
  EXPECT_EQ(leaves[0].centre, Eigen::Vector2d(-32.0, 96.0));
}

}  // namespace
}  // namespace hymm::core
