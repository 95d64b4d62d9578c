#include "hybrid_map/occupancy_quadtree.h"

#include <numeric>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "common/random.h"
#include "hybrid_map/log_odds.h"

namespace hymm::core {
namespace {

enum class Kind { kUnknown, kFree, kOccupied };

const auto kThreshold = static_cast<float>(logOddsOf(0.65));

Kind kindOf(float log_odds) {
  if (log_odds == 0.0F) return Kind::kUnknown;
  return log_odds > kThreshold ? Kind::kOccupied : Kind::kFree;
}

double sumOf(const std::vector<float>& cells) {
  return std::accumulate(cells.begin(), cells.end(), 0.0);
}

/// Patches of cells of one kind, with noise between them.
std::vector<float> randomCells(const TriangularGrid& grid, RandomGenerator& generator) {
  std::vector<float> cells(static_cast<std::size_t>(grid.cellCount()));
  const auto patch = static_cast<int>(sampleUniform(generator, 1.0, 12.0));
  const auto seed = static_cast<int>(sampleUniform(generator, 0.0, 1000.0));
  for (int j = 0; j < grid.betaCells(); ++j) {
    for (int i = 0; i < grid.rowLength(j); ++i) {
      const int kind = (i / patch * 7 + j / patch * 13 + seed) % 3;
      const double value = sampleUniform(generator, 0.7, 3.0) * (kind - 1);
      cells[static_cast<std::size_t>(grid.index(i, j))] = static_cast<float>(value);
    }
  }
  return cells;
}

RC_GTEST_PROP(OccupancyQuadtree, GivesBackWhichCellsAreOccupiedFreeAndUnknown, ()) {
  RandomGenerator generator(*rc::gen::inRange<std::uint64_t>(0, 1ULL << 40U));
  const TriangularGrid grid(*rc::gen::inRange(1, 70), *rc::gen::inRange(1, 70));
  const std::vector<float> before = randomCells(grid, generator);
  const OccupancyQuadtree tree(grid, before, kThreshold);
  const std::vector<float> after = tree.unpack();
  RC_ASSERT(after.size() == before.size());
  RC_ASSERT(tree.unpackedBytes() == before.size() * sizeof(float));
  for (std::size_t i = 0; i < before.size(); ++i) RC_ASSERT(kindOf(after[i]) == kindOf(before[i]));
  // Their evidence is only shared out anew; floats of up to 3, rounded once.
  RC_ASSERT(std::abs(sumOf(after) - sumOf(before)) < 1e-6 * static_cast<double>(before.size()));
  RC_ASSERT(OccupancyQuadtree(grid, after, kThreshold).unpack() == after);
}

TEST(OccupancyQuadtree, OfAWallInFreeSpaceIsSmall) {
  const TriangularGrid grid(150, 150);
  std::vector<float> cells(static_cast<std::size_t>(grid.cellCount()), -2.0F);
  for (int i = 0; i < grid.rowLength(20); ++i)
    cells[static_cast<std::size_t>(grid.index(i, 20))] = 3.0F;
  const OccupancyQuadtree tree(grid, cells, kThreshold);
  EXPECT_EQ(tree.unpack(), cells);
  EXPECT_LT(tree.bytes(), tree.unpackedBytes() / 150);
}

TEST(OccupancyQuadtree, OfOneKindIsASingleNode) {
  const TriangularGrid grid(100, 60);
  const std::vector<float> cells(static_cast<std::size_t>(grid.cellCount()), -1.25F);
  const OccupancyQuadtree tree(grid, cells, kThreshold);
  EXPECT_EQ(tree.bytes(), 1U);
  EXPECT_EQ(tree.unpack(), cells);
}

}  // namespace
}  // namespace hymm::core
