#include "ros/dense_map_mirror.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hymm {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;

nav_msgs::OccupancyGrid grid() {
  nav_msgs::OccupancyGrid message;
  message.header.frame_id = "map";
  message.info.resolution = 0.2F;
  message.info.width = 3;
  message.info.height = 2;
  message.info.origin.position.x = -0.4;
  message.info.origin.orientation.w = 1.0;
  message.data = {0, 0, 100, -1, -1, 0};
  return message;
}

map_msgs::OccupancyGridUpdate update(int x) {
  map_msgs::OccupancyGridUpdate message;
  message.header.frame_id = "map";
  message.x = x;
  message.width = message.height = 1;
  message.data = {50};
  return message;
}

TEST(DenseMapMirror, TellsTheMapWithItsUpdates) {
  CauseLog causes;
  DenseMapMirror mirror("map", causes);
  EXPECT_FALSE(mirror.takeChanged());
  EXPECT_FALSE(mirror.hasMap());
  mirror.takeUpdate(update(0));  // before its map
  mirror.takeMap(grid());
  mirror.takeUpdate(update(1));
  const auto image = mirror.takeChanged();
  ASSERT_TRUE(image);
  EXPECT_TRUE(mirror.hasMap());
  EXPECT_EQ(image->corner, Eigen::Vector2i(-2, 0));
  EXPECT_THAT(image->cells, ElementsAre(0, 50, 100, -1, -1, 0));
  EXPECT_FALSE(mirror.takeChanged());
  mirror.tellAgain();
  EXPECT_TRUE(mirror.takeChanged());
  EXPECT_THAT(causes.counts(), IsEmpty());
}

TEST(DenseMapMirror, RefusesAndCountsWhatCannotBeUsed) {
  CauseLog causes;
  DenseMapMirror mirror("map", causes);
  nav_msgs::OccupancyGrid bad = grid();
  bad.header.frame_id = "odom";
  mirror.takeMap(bad);
  bad = grid();
  bad.info.resolution = std::numeric_limits<float>::quiet_NaN();
  mirror.takeMap(bad);
  bad = grid();
  bad.data.pop_back();
  mirror.takeMap(bad);
  bad = grid();
  bad.info.width = std::numeric_limits<std::uint32_t>::max();
  mirror.takeMap(bad);
  bad.info.height = 0;
  bad.data.clear();
  mirror.takeMap(bad);
  bad = grid();
  bad.info.origin.position.y = 1e300;
  mirror.takeMap(bad);
  bad = grid();
  bad.info.origin.orientation.z = 0.7;
  mirror.takeMap(bad);
  EXPECT_FALSE(mirror.takeChanged());
  mirror.takeMap(grid());
  mirror.takeUpdate(update(3));
  EXPECT_THAT(causes.counts(),
              ElementsAre(Pair("dense map updates that do not fit", 1U),
                          Pair("dense maps in another frame", 1U), Pair("dense maps refused", 6U)));
  EXPECT_THAT(mirror.takeChanged()->cells, ElementsAre(0, 0, 100, -1, -1, 0));
}

}  // namespace
}  // namespace hymm
