#include "scene/level_set_mesh.h"

#include <limits>

#include <gmock/gmock.h>

#include "hybrid_map/ltr_geometry.h"

namespace hymm::core {
namespace {

using testing::HasSubstr;

TEST(LevelSetMesh, CoversEachLeafOnce) {
  const FlatVertices vertices = levelSetTriangles({{10, 20, 4, 1}, {13, 19, 2, 1}}, 0, 1, 0.5F);
  ASSERT_EQ(vertices.positions.size(), 12U);
  double area = 0.0;
  for (std::size_t i = 0; i < vertices.positions.size(); i += 3) {
    const double doubled =
        turn(vertices.positions[i].cast<double>(), vertices.positions[i + 1].cast<double>(),
             vertices.positions[i + 2].cast<double>());
    EXPECT_GT(doubled, 0.0);
    area += 0.5 * doubled;
  }
  EXPECT_DOUBLE_EQ(area, 20.0);
  EXPECT_EQ(vertices.positions[0], Eigen::Vector2f(8, 18));
}

TEST(LevelSetMesh, TellsIslandsAndValuesApart) {
  EXPECT_NE(pixelOf(levelSetColour(1, 0, 3)), pixelOf(levelSetColour(2, 0, 3)));
  const Colour low = levelSetColour(1, 0, 3), high = levelSetColour(1, 2, 3);
  EXPECT_GT(high.red + high.green + high.blue, low.red + low.green + low.blue);
}

TEST(LevelSetMesh, RefusesSquaresThatAreNone) {
  EXPECT_FALSE(problemWith(std::vector<ShownLeaf>{{0, 0, 1, 0}}));
  EXPECT_THAT(problemWith({{0, 0, 1, 0}, {0, 0, 0, 0}}).value_or(""), HasSubstr("leaf 1"));
  EXPECT_THAT(
      problemWith(std::vector<ShownLeaf>{{std::numeric_limits<double>::infinity(), 0, 1, 0}})
          .value_or(""),
      HasSubstr("leaf 0"));
}

}  // namespace
}  // namespace hymm::core
