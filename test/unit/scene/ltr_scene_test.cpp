#include "scene/ltr_scene.h"

#include <gmock/gmock.h>

namespace hymm::core {
namespace {

LandmarkMap mapOf(const std::vector<Eigen::Vector2d>& places) {
  LandmarkMap map;
  for (const Eigen::Vector2d& place : places) {
    LandmarkEstimate landmark;
    landmark.id = 10 * static_cast<int>(map.landmarks.size() + 1);
    landmark.position = place;
    map.landmarks.push_back(landmark);
  }
  return map;
}

LtrTopology ltr(int a, int b, int c) {
  LtrTopology result;
  result.landmark_ids = {a, b, c};
  return result;
}

TEST(LtrScene, FindsCornersByTheIdsOfLandmarks) {
  const LandmarkMap map = mapOf({{0, 0}, {4, 0}, {0, 3}});
  const auto corners = findCorners(map, ltr(20, 30, 10));
  ASSERT_TRUE(corners);
  EXPECT_EQ((*corners)[0], Eigen::Vector2d(4, 0));
  EXPECT_EQ((*corners)[2], Eigen::Vector2d(0, 0));
}

TEST(LtrScene, HasNoCornersWhileALandmarkIsMissing) {
  EXPECT_FALSE(findCorners(mapOf({{0, 0}, {4, 0}}), ltr(10, 20, 30)));
  EXPECT_FALSE(findCorners(LandmarkMap{}, ltr(10, 20, 30)));
}

// A cell's middle, through texture coordinates, is the middle of its pixel.
TEST(LtrScene, LaysEachCellOnItsPixel) {
  constexpr int kPage = 256, kAlphaCells = 30, kBetaCells = 20;
  const AtlasPlace place = {0, 48, 16, kAlphaCells + 2, kBetaCells + 2};
  const auto corners = textureCorners(place, kPage);
  for (const auto& [i, j] : {std::pair(0, 0), std::pair(29, 0), std::pair(7, 11)}) {
    const float alpha = (static_cast<float>(i) + 0.5F) / kAlphaCells;
    const float beta = (static_cast<float>(j) + 0.5F) / kBetaCells;
    const Eigen::Vector2f pixel =
        kPage * (corners[0] + alpha * (corners[1] - corners[0]) + beta * (corners[2] - corners[0]));
    EXPECT_NEAR(pixel.x(), static_cast<float>(place.x + 1 + i) + 0.5F, 1e-3F);  // of a float
    EXPECT_NEAR(pixel.y(), static_cast<float>(place.y + 1 + j) + 0.5F, 1e-3F);
  }
}

TEST(LtrScene, ListsASharedSideOnce) {
  const auto sides = sidesOf({ltr(1, 2, 3), ltr(3, 2, 4)});
  EXPECT_THAT(sides,
              testing::UnorderedElementsAre(std::pair(1, 2), std::pair(2, 3), std::pair(1, 3),
                                            std::pair(2, 4), std::pair(3, 4)));
}

TEST(LtrScene, MakesALineAsWideAsAskedFor) {
  const auto corners = wideLine({1, 1}, {5, 1}, 0.5);
  double area = 0.0;
  for (std::size_t i = 0; i < 6; i += 3) {
    area += 0.5 * turn(corners[i], corners[i + 1], corners[i + 2]);
  }
  EXPECT_DOUBLE_EQ(area, 2.0);
}

TEST(LtrScene, MakesALineOfNoLengthWithoutNan) {
  for (const Eigen::Vector2d& corner : wideLine({1, 1}, {1, 1}, 0.5)) {
    EXPECT_TRUE(corner.allFinite());
  }
}

}  // namespace
}  // namespace hymm::core
