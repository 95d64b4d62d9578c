#include "evaluation/trajectory.h"

#include <stdexcept>

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

TEST(Trajectory, InterpolatesPositionAndTheShorterTurn) {
  const Trajectory trajectory({{10.0, {0.0, 0.0, 3.0}}, {10.5, {1.0, -2.0, -3.0}}});
  const auto pose = trajectory.at(10.25);
  ASSERT_TRUE(pose);
  EXPECT_DOUBLE_EQ(pose->x_m, 0.5);
  EXPECT_DOUBLE_EQ(pose->y_m, -1.0);
  EXPECT_NEAR(std::abs(pose->yaw_rad), kPi, 1e-12);
}

TEST(Trajectory, KnowsNothingOutsideItsTime) {
  const Trajectory trajectory({{1.0, {}}, {2.0, {}}});
  EXPECT_FALSE(trajectory.at(0.999));
  EXPECT_TRUE(trajectory.at(1.0));
  EXPECT_TRUE(trajectory.at(2.0));
  EXPECT_FALSE(trajectory.at(2.001));
}

TEST(Trajectory, DoesNotBridgeALongGap) {
  const Trajectory trajectory({{0.0, {}}, {1.0 + kLongestInterpolation_s, {}}});
  EXPECT_FALSE(trajectory.at(0.5));
}

TEST(Trajectory, RefusesTimesThatDoNotIncrease) {
  EXPECT_THROW(Trajectory({{1.0, {}}, {1.0, {}}}), std::invalid_argument);
}

}  // namespace
}  // namespace hymm::core
