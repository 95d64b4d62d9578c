#include "common/pose2.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace hymm::core {
namespace {

double anyNumber(double limit) { return *rc::gen::inRange(-1'000'000, 1'000'001) * 1e-6 * limit; }

Pose2 anyPose() { return {anyNumber(1000.0), anyNumber(1000.0), wrapAngle(anyNumber(kPi))}; }

Eigen::Vector2d anyPoint() { return {anyNumber(1000.0), anyNumber(1000.0)}; }

/// Largest difference of two poses that lie within a few kilometres, in metres or radians.
double difference(const Pose2& a, const Pose2& b) {
  return std::max((a.position() - b.position()).norm(), std::abs(wrapAngle(a.yaw_rad - b.yaw_rad)));
}

// Rounding of kilometres that a few rotations multiply.
constexpr double kRounding = 1e-11;

RC_GTEST_PROP(Pose2, ComposesAssociatively, ()) {
  const Pose2 a = anyPose(), b = anyPose(), c = anyPose();
  RC_ASSERT(difference((a * b) * c, a * (b * c)) < kRounding);
}

RC_GTEST_PROP(Pose2, IsUndoneByItsInverseFromBothSides, ()) {
  const Pose2 a = anyPose();
  RC_ASSERT(difference(a * inverse(a), Pose2{}) < kRounding);
  RC_ASSERT(difference(inverse(a) * a, Pose2{}) < kRounding);
}

RC_GTEST_PROP(Pose2, IsUnchangedByTheIdentity, ()) {
  const Pose2 a = anyPose();
  RC_ASSERT(difference(a * Pose2{}, a) == 0.0);
  RC_ASSERT(difference(Pose2{} * a, a) == 0.0);
}

RC_GTEST_PROP(Pose2, MovesPointsAsItsFactorsDo, ()) {
  const Pose2 a = anyPose(), b = anyPose();
  const Eigen::Vector2d p = anyPoint();
  RC_ASSERT(((a * b) * p - a * (b * p)).norm() < kRounding);
}

RC_GTEST_PROP(Pose2, KeepsDistances, ()) {
  const Pose2 a = anyPose();
  const Eigen::Vector2d p = anyPoint(), q = anyPoint();
  RC_ASSERT(std::abs((a * p - a * q).norm() - (p - q).norm()) < kRounding);
}

RC_GTEST_PROP(Pose2, KeepsItsYawWithinHalfATurn, ()) {
  const Pose2 a = anyPose(), b = anyPose();
  RC_ASSERT(std::abs((a * b).yaw_rad) <= kPi);
  RC_ASSERT(std::abs(inverse(a).yaw_rad) <= kPi);
}

RC_GTEST_PROP(Pose2, GoesThroughAVector, ()) {
  const Pose2 a = anyPose();
  RC_ASSERT(difference(Pose2::fromVector(a.vector()), a) == 0.0);
}

TEST(Pose2, TurnsCounterClockwiseBeforeItMoves) {
  const Pose2 T_map_base{10.0, 20.0, kPi / 2.0};
  const Eigen::Vector2d one_ahead = T_map_base * Eigen::Vector2d(1.0, 0.0);
  EXPECT_NEAR(one_ahead.x(), 10.0, 1e-14);
  EXPECT_NEAR(one_ahead.y(), 21.0, 1e-14);
  const Eigen::Vector2d one_to_the_left = T_map_base * Eigen::Vector2d(0.0, 1.0);
  EXPECT_NEAR(one_to_the_left.x(), 9.0, 1e-14);
  EXPECT_NEAR(one_to_the_left.y(), 20.0, 1e-14);
}

TEST(Pose2, WrapsTheYawOfAVector) {
  EXPECT_NEAR(Pose2::fromVector({0.0, 0.0, 1.5 * kPi}).yaw_rad, -0.5 * kPi, 1e-15);
}

}  // namespace
}  // namespace hymm::core
