#include "cekf/gps_datum.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "cekf/cekf_slam.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;

/// A robot without landmarks, whose odometry is right, and its receiver: a fix a second, of
/// deviation 0.5 m, though it claims 1 m. East lies along the map's y axis.
class GpsDatumTest : public testing::Test {
 protected:
  GpsDatumTest() : slam_(config(), VehicleConfig{}) {}

  static CekfSlamConfig config() {
    CekfSlamConfig config;
    config.motion_input = "odom";
    config.observation_input = "detections";
    config.gps.enabled = true;
    return config;
  }

  /// Fixes are off by `bias` (east, north).
  void drive(int seconds, double speed_mps, const Vector2d& bias = Vector2d::Zero()) {
    constexpr double kStep_s = 0.1, kYawRate_radps = 0.05;
    for (int i = 0; i < 10 * seconds; ++i) {
      time_s_ += kStep_s;
      const double yaw_rate = speed_mps > 0.0 ? kYawRate_radps : 0.0;
      place_ += kStep_s * speed_mps * Vector2d(std::cos(yaw_rad_), std::sin(yaw_rad_));
      yaw_rad_ += kStep_s * yaw_rate;
      slam_.process(MotionInput(TwistInput{time_s_, speed_mps, 0.0, yaw_rate}));
      if (i % 10 == 9) fix(bias);
    }
  }

  void fix(const Vector2d& bias) {
    const Vector2d noise(normal_(generator_), normal_(generator_));
    GpsFix fix;
    fix.time_s = time_s_;
    fix.position = Vector2d(place_.y(), -place_.x()) + bias + 0.5 * noise;
    slam_.process(fix);
  }

  std::size_t used() const { return slam_.counts().gps_used; }
  double error_m() const { return (slam_.pose().T_map_base.position() - place_).norm(); }

  CekfSlam slam_;
  double time_s_ = 1.0, yaw_rad_ = 0.0;
  Vector2d place_ = Vector2d::Zero();
  std::mt19937 generator_{3};
  std::normal_distribution<double> normal_;
};

TEST_F(GpsDatumTest, IsFoundOnceTheVehicleHasTravelled) {
  drive(60, 0.0);
  EXPECT_EQ(used(), 0U);
  drive(120, 3.0);
  EXPECT_GE(used(), 100U);
  EXPECT_LT(error_m(), 2.0);
}

TEST_F(GpsDatumTest, IsNotFoundFromAFixThatJumpsWhileTheVehicleStands) {
  drive(30, 0.0);
  fix({40.0, 0.0});
  drive(30, 0.0);
  EXPECT_EQ(used() + slam_.counts().gps_rejected, 0U);
  drive(120, 3.0);
  EXPECT_GE(used(), 100U);
  EXPECT_LT(error_m(), 2.0);
}

TEST_F(GpsDatumTest, LeavesOutFixesThatDoNotAgreeWithTheOthers) {
  drive(5, 3.0);
  fix({0.0, 40.0});
  drive(120, 3.0);
  EXPECT_GE(used(), 95U);
  EXPECT_LT(error_m(), 2.0);
}

TEST_F(GpsDatumTest, IsLookedForAnewWhereNoFixConfirmsIt) {
  const int alignment_s = 12;  // 36 m, one fix a second
  drive(alignment_s, 3.0);
  drive(60, 3.0, {100.0, 0.0});  // the receiver has jumped, and stays there
  EXPECT_GE(used(), 20U);
  EXPECT_LT(error_m(), 2.0);
}

TEST_F(GpsDatumTest, KeepsAnAlignmentThatFixesHaveConfirmed) {
  drive(60, 3.0);
  const std::size_t before = used();
  drive(60, 3.0, {100.0, 0.0});
  EXPECT_EQ(used(), before);
  EXPECT_EQ(slam_.counts().gps_rejected, 60U);
  drive(60, 3.0);
  EXPECT_GE(used(), before + 50U);
}

}  // namespace
}  // namespace hymm::core
