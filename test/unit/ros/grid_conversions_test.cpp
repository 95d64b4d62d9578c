#include "ros/grid_conversions.h"

#include <cmath>
#include <cstdint>
#include <limits>

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/landmark_triangle.h"

namespace hymm {
namespace {

using testing::ElementsAre;

core::OccupancyImage image() {
  core::OccupancyImage image;
  image.resolution_m = 0.2;
  image.corner = {-35, 12};
  image.width = 3;
  image.height = 2;
  image.cells = {0, 100, -1, 50, -1, 7};
  return image;
}

TEST(GridConversions, AnImageSurvivesTheMessage) {
  const nav_msgs::OccupancyGrid message = toMessage(image());
  EXPECT_NEAR(message.info.origin.position.x, -7.0, 1e-12);
  EXPECT_NEAR(message.info.origin.position.y, 2.4, 1e-12);
  EXPECT_EQ(message.info.origin.orientation.w, 1.0);
  const core::OccupancyImage back = fromMessage(message);
  EXPECT_EQ(back.resolution_m, image().resolution_m);  // the float 0.2f is not
  EXPECT_EQ(back.corner, image().corner);
  EXPECT_EQ(back.width, 3);
  EXPECT_EQ(back.height, 2);
  EXPECT_EQ(back.cells, image().cells);
}

TEST(GridConversions, PatchesGoWhereTheyBelong) {
  core::OccupancyImage now = image();
  now.cells = {0, 1, 2, 3, 4, 5};
  core::OccupancyImage kept = image();
  EXPECT_TRUE(applyUpdate(toMessage(now, {1, 0, 2, 2}), kept));
  EXPECT_THAT(kept.cells, ElementsAre(0, 1, 2, 50, 4, 5));
}

TEST(GridConversions, PatchesThatDoNotFitAreRefused) {
  core::OccupancyImage kept = image();
  map_msgs::OccupancyGridUpdate update = toMessage(image(), {1, 0, 2, 2});
  update.x = 2;
  EXPECT_FALSE(applyUpdate(update, kept));
  update.x = -1;
  EXPECT_FALSE(applyUpdate(update, kept));
  update.x = 1;
  update.data.pop_back();
  EXPECT_FALSE(applyUpdate(update, kept));
  EXPECT_EQ(kept.cells, image().cells);
}

TEST(GridConversions, PatchesWhosePlaceAndSizeOverflowAreRefused) {
  core::OccupancyImage kept = image();
  map_msgs::OccupancyGridUpdate update = toMessage(image(), {1, 0, 2, 1});
  update.x = std::numeric_limits<std::int32_t>::max();
  EXPECT_FALSE(applyUpdate(update, kept));
  update.x = 1;
  update.y = std::numeric_limits<std::int32_t>::max();
  EXPECT_FALSE(applyUpdate(update, kept));
  EXPECT_EQ(kept.cells, image().cells);
}

TEST(GridConversions, LtrsSurviveTheMessage) {
  core::LtrTopology ltr;
  ltr.id = 4;
  ltr.landmark_ids = {7, 9, 12};
  ltr.neighbours = {-1, 3, -1};
  ltr.alpha_cells = 40;
  ltr.beta_cells = 50;
  ltr.observations = 12.5;
  ltr.shape_factor = 1.25;
  const LtrMap message = toMessage(std::vector{ltr}, 77);
  EXPECT_EQ(message.landmark_version, 77u);
  EXPECT_EQ(core::ltrsText(fromMessage(message)), core::ltrsText({ltr}));
}

/// A map with one LTR of 10 m, in which a scan hit something.
core::HybridMap smallMap() {
  core::HybridMapConfig config;
  config.layers = "terrain category grass asphalt";
  core::HybridMap map(config);
  map.apply(test::landmarkTriangle({{{0.0, 0.0}, {10.0, 0.0}, {0.0, 10.0}}}));
  return map;
}

TEST(GridConversions, AGridIsReadAsItsMessageSays) {
  core::HybridMap map = smallMap();
  core::PropertySample sample;
  sample.layer = "terrain";
  sample.position = {2.31, 4.87};
  sample.sample.value = 3.0;
  sample.sample.label = "asphalt";
  ASSERT_TRUE(map.insert(sample).accepted);
  const auto changed = map.changedSince(0);
  ASSERT_EQ(changed.size(), 1u);
  const LtrGrid message = toMessage(map, changed[0]);
  EXPECT_EQ(message.layer, "terrain");
  EXPECT_EQ(message.model, "category grass asphalt");
  EXPECT_EQ(message.channels, 2u);

  // Only by what LtrGrid.msg says: rows along beta, of ceil(alpha_cells * share left) cells.
  const auto topology = map.topology(core::LandmarkMap());
  ASSERT_EQ(topology.size(), 1u);
  const double corners[3][2] = {{0.0, 0.0}, {10.0, 0.0}, {0.0, 10.0}};
  const double* l1 = corners[topology[0].landmark_ids[0]];
  const double* l2 = corners[topology[0].landmark_ids[1]];
  const double* l3 = corners[topology[0].landmark_ids[2]];
  Eigen::Matrix2d M;
  M << l2[0] - l1[0], l3[0] - l1[0], l2[1] - l1[1], l3[1] - l1[1];
  const Eigen::Vector2d local = M.inverse() * (sample.position - Eigen::Vector2d(l1[0], l1[1]));
  const double alphas = message.alpha_cells, betas = message.beta_cells;
  std::size_t index = 0, total = 0;
  for (int j = 0; j < static_cast<int>(betas); ++j) {
    if (j < static_cast<int>(local.y() * betas)) {
      index += static_cast<std::size_t>(std::ceil(alphas * (betas - j) / betas));
    }
    total += static_cast<std::size_t>(std::ceil(alphas * (betas - j) / betas));
  }
  index += static_cast<std::size_t>(local.x() * alphas);
  ASSERT_EQ(message.cells.size(), 2 * total);
  for (std::size_t i = 0; i < total; ++i) {
    EXPECT_EQ(message.cells[2 * i], 0.0F);
    EXPECT_EQ(message.cells[2 * i + 1], i == index ? 3.0F : 0.0F) << i;
  }
}

TEST(GridConversions, ASampleIsPlacedWithItsCovariance) {
  PropertySample message;
  message.header.stamp = ros::Time(12.5);
  message.layer = "salinity";
  message.position.x = 2.0;
  message.position_covariance = {0.04, 0.0, 0.0, 0.01};
  message.value = 0.3;
  message.variance = 0.02;
  const core::PropertySample sample = fromMessage(message, {10.0, 5.0, M_PI / 2.0});
  EXPECT_TRUE(sample.position.isApprox(Eigen::Vector2d(10.0, 7.0)));
  EXPECT_NEAR(sample.covariance(0, 0), 0.01, 1e-12);
  EXPECT_NEAR(sample.covariance(1, 1), 0.04, 1e-12);
  EXPECT_EQ(sample.sample.time_s, 12.5);
  EXPECT_EQ(sample.sample.value, 0.3);
  EXPECT_EQ(sample.sample.variance, 0.02);
}

TEST(GridConversions, MemorySurvivesTheMessage) {
  core::GridMemory memory;
  memory.time_s = 8.0;
  memory.ltrs = 3;
  memory.in_ltrs = {1, 2, 4};
  memory.waiting_bytes = 5;
  GridStatus status;
  status.header.stamp = ros::Time(8.0);
  fillMemory(memory, status);
  core::MapMemoryLog told, kept;
  told.add(memoryOf(status));
  kept.add(memory);
  EXPECT_EQ(told.text(), kept.text());
}

}  // namespace
}  // namespace hymm
