#include "ros/filter_pairing.h"

#include <gtest/gtest.h>

namespace hymm {
namespace {

template <class Message>
Message at(double stamp_s) {
  Message message;
  message.header.stamp = ros::Time(stamp_s);
  return message;
}

class FilterPairingTest : public testing::Test {
 protected:
  void addPose(double stamp_s) { pairing_.add(at<FilterPose>(stamp_s)); }
  void addHealth(double stamp_s) { pairing_.add(at<FilterHealth>(stamp_s)); }

  /// The stamp of the next pair, 0 if there is none.
  double next() {
    const std::optional<FilterAnswer> answer = pairing_.next();
    if (!answer) return 0.0;
    EXPECT_EQ(answer->pose.header.stamp, answer->health.header.stamp);
    return answer->pose.header.stamp.toSec();
  }

  FilterPairing pairing_;
};

TEST_F(FilterPairingTest, WaitsForTheOtherHalf) {
  addPose(1.0);
  EXPECT_EQ(next(), 0.0);
  addHealth(1.0);
  EXPECT_EQ(next(), 1.0);
  EXPECT_EQ(next(), 0.0);
  EXPECT_EQ(pairing_.unpaired(), 0u);
}

TEST_F(FilterPairingTest, PassesOverWhatStaysAlone) {
  for (const double stamp_s : {1.0, 2.0, 3.0}) addPose(stamp_s);
  for (const double stamp_s : {2.0, 3.0}) addHealth(stamp_s);
  EXPECT_EQ(next(), 2.0);
  EXPECT_EQ(next(), 3.0);
  EXPECT_EQ(pairing_.unpaired(), 1u);
}

TEST_F(FilterPairingTest, GoesOnWhenTheClockRanBackOverOneAlone) {
  addPose(100.0);  // the last one of a recording, without its health
  for (const double stamp_s : {1.0, 2.0}) {
    addPose(stamp_s);
    addHealth(stamp_s);
    EXPECT_EQ(next(), stamp_s);
  }
  EXPECT_EQ(pairing_.unpaired(), 1u);
}

TEST_F(FilterPairingTest, KeepsBoundedManyThatAreAlone) {
  for (int i = 0; i < 3000; ++i) {
    addPose(1.0 + i);
    EXPECT_EQ(next(), 0.0);
  }
  EXPECT_EQ(pairing_.unpaired(), 2000u);
}

}  // namespace
}  // namespace hymm
