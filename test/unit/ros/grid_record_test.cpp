#include "ros/grid_record.h"

#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.h"

namespace hymm {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;

nav_msgs::OccupancyGrid grid() {
  nav_msgs::OccupancyGrid message;
  message.info.resolution = 0.2F;
  message.info.width = 3;
  message.info.height = 2;
  message.info.origin.orientation.w = 1.0;
  message.data = {0, 0, 0, 100, 100, 100};
  return message;
}

map_msgs::OccupancyGridUpdate update(int x, int y) {
  map_msgs::OccupancyGridUpdate message;
  message.x = x;
  message.y = y;
  message.width = message.height = 1;
  message.data = {-1};
  return message;
}

/// The picture of `grid()`, whose upper row is that of greatest y, with one cell in the place of
/// its right lower one.
std::string picture(char right_lower) {
  return "P5\n3 2\n255\n" + std::string(3, '\0') + "\xfe\xfe" + right_lower;
}

TEST(GridRecord, WritesTheMapWithItsUpdates) {
  const test::TemporaryFolder folder;
  CauseLog causes;
  GridRecord record(folder.path(), causes);
  record.takeStatus(GridStatus());
  record.takeMapUpdate(update(2, 0));  // before its map
  record.takeMap(grid());
  record.takeMapUpdate(update(2, 0));
  record.write();
  EXPECT_EQ(folder.read("map.pgm"), picture('\xcd'));
  EXPECT_THAT(causes.counts(), IsEmpty());
}

TEST(GridRecord, KeepsTheLastMapWhereOneHasOtherCellsThanItSays) {
  const test::TemporaryFolder folder;
  CauseLog causes;
  GridRecord record(folder.path(), causes);
  record.takeStatus(GridStatus());
  nav_msgs::OccupancyGrid bad = grid();
  bad.info.height = 3000;
  record.takeMap(bad);
  record.takeMapUpdate(update(2, 2999));  // would be written far behind the cells
  record.write();
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "map.pgm"));
  record.takeMap(grid());
  record.takeMap(bad);
  record.takeMapUpdate(update(2, 2999));
  bad = grid();
  bad.data.pop_back();
  record.takeMap(bad);
  record.write();
  EXPECT_EQ(folder.read("map.pgm"), picture('\xfe'));
  EXPECT_THAT(causes.counts(), ElementsAre(Pair("dense maps refused", 3U)));
}

}  // namespace
}  // namespace hymm
