#include "ros/wish_numbers.h"

#include <gtest/gtest.h>

namespace hymm {
namespace {

TEST(WishNumbers, AreZeroWithoutAWish) { EXPECT_EQ(WishNumbers().last(), 0U); }

TEST(WishNumbers, GrowThoughTheClockIsSetBack) {
  WishNumbers numbers;
  numbers.add(ros::WallTime(100.0));
  const std::uint64_t first = numbers.last();
  numbers.add(ros::WallTime(50.0));
  EXPECT_GT(numbers.last(), first);
}

class WishListenerTest : public ::testing::Test {
 protected:
  bool hears(std::uint64_t number) {
    listener_.take(number);
    return listener_.takeNew();
  }
  static std::uint64_t at(double time_s) { return WishNumbers::number(ros::WallTime(time_s)); }

  WishListener listener_{ros::WallTime(100.0)};
};

TEST_F(WishListenerTest, HearsAWishOnce) {
  EXPECT_FALSE(hears(0));
  EXPECT_TRUE(hears(at(101.0)));
  EXPECT_FALSE(hears(at(101.0)));
  EXPECT_TRUE(hears(at(102.0)));
}

TEST_F(WishListenerTest, LeavesWishesBeforeItsStartToOthers) {
  EXPECT_FALSE(hears(at(99.0)));
  EXPECT_TRUE(hears(at(101.0)));
}

TEST_F(WishListenerTest, HearsTheFirstWishThoughNothingWasToldBefore) {
  EXPECT_TRUE(hears(at(101.0)));
}

TEST_F(WishListenerTest, HearsTheFirstWishOfANodeThatWasStartedAnew) {
  EXPECT_TRUE(hears(at(101.0)));
  EXPECT_FALSE(hears(0));
  EXPECT_TRUE(hears(at(103.0)));
}

TEST_F(WishListenerTest, HearsWhoseClockIsBehindFromTheSecondNumberOn) {
  EXPECT_FALSE(hears(at(40.0)));
  EXPECT_TRUE(hears(at(41.0)));
}

TEST_F(WishListenerTest, KeepsAWishUntilItIsTaken) {
  listener_.take(at(101.0));
  listener_.take(0);
  EXPECT_TRUE(listener_.takeNew());
}

}  // namespace
}  // namespace hymm
