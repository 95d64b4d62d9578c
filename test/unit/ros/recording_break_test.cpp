#include "ros/recording_break.h"

#include <gtest/gtest.h>

namespace hymm {
namespace {

TEST(RecordingBreak, DividesAtTheFirstScanAfterAReset) {
  const RecordingBreak here{ros::Time(90.0), ros::Time(90.2)};
  EXPECT_FALSE(here.clockRanBack());
  EXPECT_TRUE(here.isBefore(ros::Time(90.1)));
  EXPECT_FALSE(here.isBefore(ros::Time(90.2)));
  EXPECT_FALSE(here.isBefore(ros::Time(95.0)));
}

TEST(RecordingBreak, GoesByTheNearerScanWhereTheClockRanBack) {
  const RecordingBreak here{ros::Time(90.0), ros::Time(5.0)};
  EXPECT_TRUE(here.clockRanBack());
  for (const double second : {88.0, 90.0, 91.5}) EXPECT_TRUE(here.isBefore(ros::Time(second)));
  for (const double second : {4.0, 5.0, 7.5}) EXPECT_FALSE(here.isBefore(ros::Time(second)));
}

TEST(RecordingBreak, StampsFarApartDoNoHarm) {
  const RecordingBreak here{ros::Time(4294967295.0), ros::Time(0.1)};
  EXPECT_FALSE(here.isBefore(ros::Time(0.0)));
  EXPECT_TRUE(here.isBefore(ros::Time(4294967295.0)));
}

}  // namespace
}  // namespace hymm
