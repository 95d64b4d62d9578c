#include "scene/layer_image.h"

#include <limits>

#include <gmock/gmock.h>

#include "hybrid_map/triangular_grid.h"

namespace hymm::core {
namespace {

using testing::HasSubstr;

constexpr float kOccupied = 5.0F, kFree = -5.0F;

ToldLayer told(const std::string& model, int channels, int alpha_cells = 3, int beta_cells = 2) {
  return {"layer_name", model, alpha_cells, beta_cells, channels};
}

std::string problemOf(const ToldLayer& layer, const std::vector<float>& cells) {
  std::string problem;
  EXPECT_FALSE(readLayer(layer, cells, problem));
  return problem;
}

LayerField field(const ToldLayer& layer, const std::vector<float>& cells) {
  std::string problem;
  const auto result = readLayer(layer, cells, problem);
  EXPECT_TRUE(result) << problem;
  return result.value_or(LayerField{});
}

// 3 x 2 cells: rows of 3 and of 2.
TEST(LayerImage, PutsEachCellBehindTheRim) {
  const LayerImage image =
      paint(field(told("occupancy", 1), {kOccupied, kFree, 0, 0, kOccupied}), {});
  ASSERT_EQ(image.width, 5);
  ASSERT_EQ(image.height, 4);
  const Pixel free = image.at(2, 1), occupied = image.at(1, 1), unknown = image.at(3, 1);
  EXPECT_GT(occupied[0], free[0]);
  EXPECT_EQ(unknown[3], 0);
  EXPECT_EQ(free[3], 255);
  EXPECT_EQ(image.at(1, 2), unknown);
  EXPECT_EQ(image.at(2, 2), occupied);
}

TEST(LayerImage, RepeatsTheBorderInTheRimAndBeyondTheTriangle) {
  const LayerImage image =
      paint(field(told("occupancy", 1), {kOccupied, kFree, 0, 0, kOccupied}), {});
  EXPECT_EQ(image.at(0, 1), image.at(1, 1));
  EXPECT_EQ(image.at(0, 0), image.at(1, 1));
  EXPECT_EQ(image.at(4, 1), image.at(3, 1));
  EXPECT_EQ(image.at(3, 2), image.at(2, 2));
  EXPECT_EQ(image.at(4, 3), image.at(2, 2));
}

TEST(LayerImage, ColoursValuesByTheirRange) {
  // Weight, mean, scatter, samples.
  const LayerField heights = field(told("gaussian", 4, 2, 1), {1, -3, 0, 1, /**/ 1, 9, 0, 1});
  ValueRange range;
  EXPECT_TRUE(range.include(heights));
  EXPECT_EQ(range.low, -3.0);
  EXPECT_EQ(range.high, 9.0);
  EXPECT_FALSE(range.include(heights));
  const LayerImage image = paint(heights, range);
  EXPECT_EQ(image.at(1, 1), pixelOf(rampColour(0.0)));
  EXPECT_EQ(image.at(2, 1), pixelOf(rampColour(1.0)));
}

TEST(LayerImage, ColoursCategoriesByTheLikeliest) {
  const LayerField terrain = field(told("category grass asphalt", 2, 2, 1), {1, 4, /**/ 3, 0});
  const LayerImage image = paint(terrain, {});
  EXPECT_EQ(image.at(1, 1), pixelOf(distinctColour(1)));
  EXPECT_EQ(image.at(2, 1), pixelOf(distinctColour(0)));
}

TEST(LayerImage, ReadsRatesOfAnyNumberOfClasses) {
  // Two weathers, working day and weekend, one part of the day: four classes of events and hours.
  const LayerField traffic = field(told("rate dry wet", 8, 1, 1), {6, 2, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(traffic.kind, LayerField::Kind::kValue);
  EXPECT_FLOAT_EQ(traffic.values[0], 3.0F);
}

TEST(LayerImage, RefusesTheWrongNumberOfCells) {
  EXPECT_THAT(problemOf(told("occupancy", 1), {1, 2, 3}),
              HasSubstr("has 3 numbers, but its 3 x 2 cells of 1 take 5"));
}

TEST(LayerImage, RefusesAModelThatIsNotKnown) {
  EXPECT_THAT(problemOf(told("fractal", 1), {1, 2, 3, 4, 5}), HasSubstr("'fractal'"));
  EXPECT_THAT(problemOf(told("", 1), {1, 2, 3, 4, 5}), HasSubstr("not known"));
  EXPECT_THAT(problemOf(told("gaussian; evil gaussian", 4), std::vector<float>(20)),
              HasSubstr("not known"));
}

TEST(LayerImage, RefusesChannelsThatAreNotTheModels) {
  EXPECT_THAT(problemOf(told("gaussian", 3), std::vector<float>(15)),
              HasSubstr("3 numbers a cell, but its model 'gaussian' has 4"));
  EXPECT_THAT(problemOf(told("rate", 0), {}), HasSubstr("0 numbers a cell"));
}

TEST(LayerImage, RefusesSidesThatNoTextureHas) {
  EXPECT_THAT(problemOf(told("occupancy", 1, 0, 2), {}), HasSubstr("0 x 2 cells"));
  EXPECT_THAT(problemOf(told("occupancy", 1, 100000, 100000), {}), HasSubstr("100000"));
}

TEST(LayerImage, LeavesOutValuesThatAreNotFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const LayerImage image = paint(field(told("occupancy", 1, 1, 1), {nan}), {});
  EXPECT_EQ(image.at(1, 1)[3], 0);
}

}  // namespace
}  // namespace hymm::core
