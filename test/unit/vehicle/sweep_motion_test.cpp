#include "vehicle/sweep_motion.h"

#include <cmath>

#include <gtest/gtest.h>

#include "common/angles.h"
#include "support/numeric_jacobian.h"
#include "vehicle/arc.h"

namespace hymm::core {
namespace {

SweepMotion turningLeft() {
  SweepMotion motion;
  motion.pieces = {{0.0, 5.0, 0.0, 0.5}};
  return motion;
}

void expectSame(const Pose2& a, const Pose2& b) {
  EXPECT_NEAR(a.x_m, b.x_m, 1e-12);
  EXPECT_NEAR(a.y_m, b.y_m, 1e-12);
  EXPECT_NEAR(wrapAngle(a.yaw_rad - b.yaw_rad), 0.0, 1e-12);
}

TEST(SweepMotion, WithoutPiecesStandsStill) {
  EXPECT_TRUE(SweepMotion().isStill());
  expectSame(SweepMotion().poseAfter(0.1), {});
}

TEST(SweepMotion, FollowsTheArcOfItsVelocity) {
  // Ten metres of radius, a quarter of a turn.
  expectSame(turningLeft().poseAfter(kPi), {10.0, 10.0, kPi / 2.0});
}

TEST(SweepMotion, PiecesOfOneVelocityAreOneMotion) {
  SweepMotion pieces = turningLeft();
  for (const double from_s : {0.025, 0.05, 0.075}) {
    pieces.pieces.push_back({from_s, 5.0, 0.0, 0.5});
  }
  for (const double after_s : {0.0, 0.01, 0.05, 0.06, 0.2}) {
    SCOPED_TRACE(after_s);
    expectSame(pieces.poseAfter(after_s), turningLeft().poseAfter(after_s));
  }
}

TEST(SweepMotion, EachVelocityHoldsUntilTheNext) {
  SweepMotion motion;
  motion.pieces = {{0.0, 2.0, 0.0, 0.0}, {0.5, 0.0, 1.0, 0.0}};
  expectSame(motion.poseAfter(0.5), {1.0, 0.0, 0.0});
  expectSame(motion.poseAfter(2.5), {1.0, 2.0, 0.0});
}

TEST(SweepMotion, MovesASensorWithItsArm) {
  // The car turns on the spot: a sensor 2 m ahead goes to its left.
  SweepMotion motion;
  motion.pieces = {{0.0, 0.0, 0.0, 1.0}};
  const Pose2 ahead{2.0, 0.0, 0.0};
  expectSame(motion.sensorPoseAfter(kPi / 2.0, ahead), {-2.0, 2.0, kPi / 2.0});
  const Pose2 turned{0.0, 0.0, 1.0};
  expectSame(motion.sensorPoseAfter(0.5, turned), {0.0, 0.0, 0.5});
}

TEST(SweepMotion, CarriesTheCovarianceOfTheVelocityToTheSensor) {
  SweepMotion motion;  // from rest, so that the derivative of the arc is exact
  motion.pieces = {{0.0, 0.0, 0.0, 0.0}};
  motion.velocity_covariance = Eigen::Vector3d(0.04, 0.01, 0.0009).asDiagonal();
  const Pose2 T_base_sensor{3.0, 0.5, 0.7};
  constexpr double kAfter_s = 0.1;
  const auto poseOf = [&](const Eigen::VectorXd& velocity) -> Eigen::VectorXd {
    SweepMotion moved;
    moved.pieces = {{0.0, velocity[0], velocity[1], velocity[2]}};
    return moved.sensorPoseAfter(kAfter_s, T_base_sensor).vector();
  };
  const Eigen::MatrixXd J = test::numericJacobian(poseOf, Eigen::VectorXd::Zero(3));
  const Eigen::Matrix3d expected = J * motion.velocity_covariance * J.transpose();
  EXPECT_NEAR(
      (motion.sensorCovarianceAfter(kAfter_s, T_base_sensor) - expected).cwiseAbs().maxCoeff(), 0.0,
      1e-10);
}

TEST(SweepMotion, WhiteNoiseGrowsWithTime) {
  SweepMotion motion;
  motion.white_density = Eigen::Vector3d(0.0, 0.01, 0.0).asDiagonal();
  EXPECT_NEAR(motion.covarianceAfter(0.1)(1, 1), 0.001, 1e-15);
  EXPECT_NEAR(motion.covarianceAfter(0.2)(1, 1), 0.002, 1e-15);
}

}  // namespace
}  // namespace hymm::core
