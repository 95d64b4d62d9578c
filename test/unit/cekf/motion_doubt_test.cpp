#include "cekf/motion_doubt.h"

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

TEST(MotionDoubt, BelievesTheMotionOfAFilterThatWasLostOnce) {
  const MotionDoubt doubt = MotionDoubt().afterReturn(100.0, 105.0);
  EXPECT_LT(doubt.until_s, 0.0);
}

TEST(MotionDoubt, FallsOnTheMotionOfAFilterThatIsLostAgainSoon) {
  const MotionDoubt doubt = MotionDoubt().afterReturn(100.0, 105.0).afterReturn(120.0, 124.0);
  EXPECT_EQ(doubt.until_s, 124.0 + MotionDoubt::kFirst_s);
}

TEST(MotionDoubt, LastsTwiceAsLongEachTime) {
  MotionDoubt doubt = MotionDoubt().afterReturn(100.0, 105.0);
  doubt = doubt.afterReturn(120.0, 124.0);
  doubt = doubt.afterReturn(doubt.until_s + 10.0, doubt.until_s + 15.0);
  EXPECT_EQ(doubt.until_s - doubt.back_s, 2.0 * MotionDoubt::kFirst_s);
}

TEST(MotionDoubt, IsForgottenAfterALongTimeInGoodOrder) {
  MotionDoubt doubt = MotionDoubt().afterReturn(100.0, 105.0);
  doubt = doubt.afterReturn(120.0, 124.0);
  const double later_s = doubt.until_s + MotionDoubt::kFirst_s + 1.0;
  doubt = doubt.afterReturn(later_s, later_s + 5.0);
  EXPECT_LT(doubt.until_s, 0.0);
  EXPECT_EQ(doubt.lasting_s, 0.0);
}

}  // namespace
}  // namespace hymm::core
