#include "common/angles.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace hymm::core {
namespace {

/// Angles of up to a thousand turns.
rc::Gen<double> anyAngle() {
  return rc::gen::map(rc::gen::inRange(-360'000'000, 360'000'001),
                      [](int millidegrees) { return millidegrees * 1e-3 * kPi / 180.0; });
}

RC_GTEST_PROP(WrapAngle, StaysWithinHalfATurn, ()) {
  const double wrapped = wrapAngle(*anyAngle());
  RC_ASSERT(std::abs(wrapped) <= kPi);
}

RC_GTEST_PROP(WrapAngle, KeepsTheDirection, ()) {
  const double angle = *anyAngle();
  const double wrapped = wrapAngle(angle);
  // The sine and cosine of an angle of a thousand turns carry its rounding.
  RC_ASSERT(std::abs(std::cos(wrapped) - std::cos(angle)) < 1e-11);
  RC_ASSERT(std::abs(std::sin(wrapped) - std::sin(angle)) < 1e-11);
}

TEST(WrapAngle, KeepsAnglesWithinHalfATurnExactly) {
  for (const double angle : {-kPi, -1.5, -1e-300, 0.0, 0.25, 3.0, kPi}) {
    EXPECT_EQ(wrapAngle(angle), angle);
  }
}

TEST(WrapAngle, DoesNotHideInvalidAngles) {
  EXPECT_TRUE(std::isnan(wrapAngle(std::nan(""))));
  EXPECT_TRUE(std::isnan(wrapAngle(INFINITY)));
}

}  // namespace
}  // namespace hymm::core
