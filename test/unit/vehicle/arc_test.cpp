#include "vehicle/arc.h"

#include <cmath>

#include <gtest/gtest.h>

#include "vehicle/motion_model.h"

namespace hymm::core {
namespace {

Eigen::Vector3d displacement(const Eigen::Vector3d& velocity, double duration_s) {
  const Eigen::Vector2d moved = Arc(velocity.z() * duration_s).V() * velocity.head<2>();
  return {moved.x() * duration_s, moved.y() * duration_s, velocity.z() * duration_s};
}

class ArcAtTurn : public testing::TestWithParam<double> {};

TEST_P(ArcAtTurn, JacobianEqualsFiniteDifferences) {
  const double duration_s = 0.4;
  const Eigen::Vector3d velocity(1.3, -0.2, GetParam() / duration_s);
  const Eigen::Matrix3d J =
      Arc(GetParam()).velocityJacobian(velocity.head<2>() * duration_s, duration_s);
  const double h = 1e-5;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d d = Eigen::Vector3d::Unit(i) * h;
    const Eigen::Vector3d numeric =
        (displacement(velocity + d, duration_s) - displacement(velocity - d, duration_s)) / (2 * h);
    EXPECT_LT((J.col(i) - numeric).norm(), 1e-9) << "column " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Turns, ArcAtTurn,
                         testing::Values(-1.2, -2e-4, 0.0, 5e-5, 9.9e-3, 1.01e-2, 0.3, 3.0));

TEST(Arc, SeriesMeetsClosedFormWhereTheyChange) {
  const Arc below(std::nextafter(1e-2, 0.0)), above(1e-2);
  EXPECT_LT((below.V() - above.V()).norm(), 1e-15);
  EXPECT_LT((below.dV() - above.dV()).norm(), 1e-13);
}

TEST(Arc, FollowsCircle) {
  const double radius_m = 5.0, turn = kPi / 2.0;
  const Eigen::Vector2d moved = Arc(turn).V() * Eigen::Vector2d(radius_m * turn, 0.0);
  EXPECT_NEAR(moved.x(), radius_m, 1e-12);
  EXPECT_NEAR(moved.y(), radius_m, 1e-12);
}

TEST(MotionModel, UsesNoiseThatTheTwistStates) {
  const Eigen::Matrix3d density = Eigen::Vector3d(1e-4, 4e-4, 9e-4).asDiagonal();
  const TwistInput input{0.0, 0.0, 0.0, 0.0, density};
  const MotionStep step =
      MotionModel(VehicleConfig{}).step(Pose2{}, input, Calibration{}, 0.0, 0.25);
  EXPECT_LT((step.noise - density * 0.25).norm(), 1e-15);
}

}  // namespace
}  // namespace hymm::core
