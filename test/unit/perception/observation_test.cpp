#include "perception/observation.h"

#include <cmath>

#include <gtest/gtest.h>

#include "common/angles.h"
#include "support/numeric_jacobian.h"

namespace hymm::core {
namespace {

constexpr double kEps = 1e-12;
const Eigen::Matrix3d kExactly = Eigen::Matrix3d::Zero();

Observation trunkAt(double range_m, double bearing_rad) {
  Observation seen;
  seen.range_m = range_m;
  seen.bearing_rad = bearing_rad;
  seen.covariance << 4e-4, 1e-5, 1e-5, 9e-6;
  seen.diameter_covariance << 2e-4, 3e-6;
  seen.after_stamp_s = 0.05;
  return seen;
}

TEST(ObservationAsOfStamp, IsTheSameForASensorThatStoodStill) {
  const Observation seen = trunkAt(12.0, -2.0);
  const Observation then = asOfStamp(seen, {}, kExactly);
  EXPECT_NEAR(then.range_m, seen.range_m, kEps);
  EXPECT_NEAR(then.bearing_rad, seen.bearing_rad, kEps);
  EXPECT_NEAR((then.covariance - seen.covariance).norm(), 0.0, kEps);
  EXPECT_NEAR((then.diameter_covariance - seen.diameter_covariance).norm(), 0.0, kEps);
  EXPECT_EQ(then.after_stamp_s, 0.0);
}

TEST(ObservationAsOfStamp, SeesTheSamePlaceFromWhereTheSensorWas) {
  // Half a metre ahead and turned left by then: 10 m to its left is 0.5 m ahead and 10 m left.
  const Observation straight = asOfStamp(trunkAt(10.0, kPi / 2.0), {0.5, 0.0, 0.0}, kExactly);
  EXPECT_NEAR(straight.range_m, std::hypot(0.5, 10.0), kEps);
  EXPECT_NEAR(straight.bearing_rad, std::atan2(10.0, 0.5), kEps);
  const Observation turned = asOfStamp(trunkAt(10.0, 3.0), {0.0, 0.0, 0.3}, kExactly);
  EXPECT_NEAR(turned.range_m, 10.0, kEps);
  EXPECT_NEAR(turned.bearing_rad, 3.3 - 2.0 * kPi, kEps);
}

TEST(ObservationAsOfStamp, PropagatesAllCovariancesToFirstOrder) {
  const Pose2 moved{0.4, -0.2, 0.1};
  const Eigen::Matrix3d P = Eigen::Vector3d(1e-4, 4e-4, 1e-6).asDiagonal();
  const auto polar = [](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    Observation seen;
    seen.range_m = x[0];
    seen.bearing_rad = x[1];
    const Observation then = asOfStamp(seen, Pose2{x[2], x[3], x[4]}, Eigen::Matrix3d::Zero());
    return Eigen::Vector2d(then.range_m, then.bearing_rad);
  };
  const Observation seen = trunkAt(3.0, 1.2);
  Eigen::VectorXd x(5);
  x << seen.range_m, seen.bearing_rad, moved.vector();
  const Eigen::MatrixXd J = test::numericJacobian(polar, x);
  const Eigen::Matrix2d by_seen = J.leftCols<2>();
  const Eigen::Matrix2d expected = by_seen * seen.covariance * by_seen.transpose() +
                                   J.rightCols<3>() * P * J.rightCols<3>().transpose();
  const Observation then = asOfStamp(seen, moved, P);
  EXPECT_NEAR((then.covariance - expected).cwiseAbs().maxCoeff(), 0.0, kEps);
  EXPECT_NEAR((then.diameter_covariance - by_seen * seen.diameter_covariance).norm(), 0.0, kEps);
}

}  // namespace
}  // namespace hymm::core
