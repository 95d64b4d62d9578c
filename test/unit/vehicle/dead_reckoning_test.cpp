#include "vehicle/dead_reckoning.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// Two seconds at 1 m/s, straight ahead.
DeadReckoning driven() {
  DeadReckoning reckoning(VehicleConfig{});
  for (int i = 0; i <= 20; ++i) {
    EXPECT_TRUE(reckoning.process(TwistInput{10.0 + 0.1 * i, 1.0, 0.0, 0.0}));
  }
  return reckoning;
}

TEST(DeadReckoning, StartsAtTheOriginWithTheFirstInput) {
  DeadReckoning reckoning(VehicleConfig{});
  EXPECT_FALSE(reckoning.velocity().has_value());
  EXPECT_TRUE(reckoning.process(TwistInput{1e9, 5.0, 0.0, 0.0}));
  EXPECT_EQ(reckoning.T_odom_base().vector().norm(), 0.0);
  EXPECT_EQ(reckoning.covariance().norm(), 0.0);
  ASSERT_TRUE(reckoning.velocity().has_value());
  EXPECT_EQ(reckoning.velocity()->forward_mps, 5.0);
}

TEST(DeadReckoning, HoldsEachInputUntilTheNext) {
  DeadReckoning reckoning(VehicleConfig{});
  reckoning.process(TwistInput{0.0, 1.0, 0.0, 0.0});
  reckoning.process(TwistInput{2.0, 3.0, 0.0, 0.0});
  EXPECT_NEAR(reckoning.T_odom_base().x_m, 2.0, 1e-12);
  reckoning.process(TwistInput{3.0, 0.0, 0.0, 0.0});
  EXPECT_NEAR(reckoning.T_odom_base().x_m, 5.0, 1e-12);
}

TEST(DeadReckoning, ComesBackAfterAFullCircle) {
  VehicleConfig vehicle;
  vehicle.ackermann = {2.83, 0.76};
  DeadReckoning reckoning(vehicle);
  const AckermannInput input{0.0, 4.0, 0.3};
  const double yaw_rate = MotionModel(vehicle).velocity(input, {}).yaw_rate_radps;
  const int steps = 400;
  for (int i = 0; i <= steps; ++i) {
    reckoning.process(AckermannInput{2.0 * kPi / yaw_rate * i / steps, 4.0, 0.3});
  }
  EXPECT_LT(reckoning.T_odom_base().position().norm(), 1e-10);
  EXPECT_NEAR(reckoning.T_odom_base().yaw_rad, 0.0, 1e-10);
}

TEST(DeadReckoning, GrowsLessCertain) {
  DeadReckoning reckoning(VehicleConfig{});
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  reckoning.process(TwistInput{0.0, 2.0, 0.0, 0.1});
  for (int i = 1; i < 20; ++i) {
    reckoning.process(TwistInput{0.1 * i, 2.0, 0.0, 0.1});
    const Eigen::Vector3d variances = reckoning.covariance().diagonal();
    EXPECT_TRUE((variances.array() > before.array()).all());
    before = variances;
  }
}

struct BadInput {
  const char* name;
  MotionInput input;
};

void PrintTo(const BadInput& bad, std::ostream* stream) { *stream << bad.name; }

class DeadReckoningRefuses : public testing::TestWithParam<BadInput> {};

TEST_P(DeadReckoningRefuses, AndChangesNothing) {
  DeadReckoning reckoning = driven();
  const Pose2 pose = reckoning.T_odom_base();
  const Eigen::Matrix3d covariance = reckoning.covariance();
  EXPECT_FALSE(reckoning.process(GetParam().input));
  EXPECT_EQ(reckoning.T_odom_base().vector(), pose.vector());
  EXPECT_EQ(reckoning.covariance(), covariance);
  EXPECT_EQ(reckoning.time_s(), 12.0);
  EXPECT_EQ(reckoning.velocity()->forward_mps, 1.0);

  // It goes on as if the refused input had not come.
  EXPECT_TRUE(reckoning.process(TwistInput{13.0, 1.0, 0.0, 0.0}));
  EXPECT_NEAR(reckoning.T_odom_base().x_m, 3.0, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(BadInputs, DeadReckoningRefuses,
                         testing::Values(BadInput{"CarStampNaN", AckermannInput{kNaN, 9.0, 0.0}},
                                         BadInput{"SpeedNaN", AckermannInput{12.1, kNaN, 0.0}},
                                         BadInput{"SteeringInf", AckermannInput{12.1, 9.0, kInf}},
                                         BadInput{"TwistStampInf", TwistInput{kInf, 9.0, 0.0, 0.0}},
                                         BadInput{"ForwardInf", TwistInput{12.1, -kInf, 0.0, 0.0}},
                                         BadInput{"LateralNaN", TwistInput{12.1, 9.0, kNaN, 0.0}},
                                         BadInput{"YawRateNaN", TwistInput{12.1, 9.0, 0.0, kNaN}},
                                         BadInput{"SameStamp", TwistInput{12.0, 9.0, 0.0, 0.0}},
                                         BadInput{"EarlierStamp",
                                                  TwistInput{11.9, 9.0, 0.0, 0.0}}));

TEST(DeadReckoning, ResetsToTheOriginAndTakesOlderTimes) {
  DeadReckoning reckoning = driven();
  reckoning.reset();
  EXPECT_EQ(reckoning.T_odom_base().vector().norm(), 0.0);
  EXPECT_EQ(reckoning.covariance().norm(), 0.0);
  EXPECT_FALSE(reckoning.velocity().has_value());
  EXPECT_TRUE(reckoning.process(TwistInput{1.0, 1.0, 0.0, 0.0}));
  EXPECT_EQ(reckoning.T_odom_base().vector().norm(), 0.0);
}

}  // namespace
}  // namespace hymm::core
