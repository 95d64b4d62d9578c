#include "cekf/motion_noise_scale.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "common/random.h"

namespace hymm::core {
namespace {

/// Scans, five a second, each of which measures the error of a motion that has the variance `truth`
/// times what is claimed, by a sensor whose variance is `sensor` times that.
class MotionNoiseScaleTest : public testing::Test {
 protected:
  void drive(const Eigen::Vector2d& truth, double sensor, double duration_s) {
    const int scans = static_cast<int>(duration_s * 5.0);
    for (int i = 0; i < scans; ++i) {
      MotionNoiseScale::Evidence evidence;
      for (int k = 0; k < 2; ++k) {
        const double M = scale_.factors()[k], S = M + sensor;
        const double y = sampleNormal(generator_, std::sqrt(truth[k] + sensor));
        evidence.slope[k] = 0.5 * (y * y / S - 1.0) * M / S;
        evidence.information(k, k) = 0.5 * (M / S) * (M / S);
      }
      scale_.learn(time_s_ += 0.2, evidence);
    }
  }

  double translation() const { return scale_.factors()[MotionNoiseScale::kTranslation]; }
  double rotation() const { return scale_.factors()[MotionNoiseScale::kRotation]; }

  RandomGenerator generator_{1};
  double time_s_ = 0.0;
  MotionNoiseScale scale_{MotionNoiseConfig{}};
};

TEST_F(MotionNoiseScaleTest, BelievesTheClaimsAtFirst) {
  EXPECT_EQ(scale_.factors(), Eigen::Vector2d::Ones());
}

TEST_F(MotionNoiseScaleTest, StaysNearOneWhereClaimsAreRight) {
  double largest = 0.0;
  for (int i = 0; i < 100; ++i) {
    drive({1.0, 1.0}, 1.0, 10.0);
    largest = std::max({largest, translation(), rotation()});
  }
  EXPECT_GT(largest, 1.0);
  EXPECT_LT(largest, 2.0);
}

TEST_F(MotionNoiseScaleTest, FindsWhichNoiseIsLargerWithinSeconds) {
  drive({9.0, 1.0}, 1.0, 20.0);
  EXPECT_NEAR(std::log(translation()), std::log(9.0), std::log(1.6));
  EXPECT_LT(rotation(), 1.5);
}

TEST_F(MotionNoiseScaleTest, IsNeverBelowOne) {
  drive({0.1, 0.1}, 0.1, 100.0);
  EXPECT_EQ(scale_.factors(), Eigen::Vector2d::Ones());
}

TEST_F(MotionNoiseScaleTest, ForgetsWhatIsLongAgo) {
  drive({9.0, 9.0}, 1.0, 60.0);
  const double before = translation();
  scale_.learn(time_s_ + 10.0 * MotionNoiseConfig{}.memory_s, {});
  EXPECT_GT(before, 5.0);
  EXPECT_LT(translation(), 1.001);
}

TEST_F(MotionNoiseScaleTest, FollowsAClaimThatBecomesRightAgain) {
  drive({9.0, 9.0}, 1.0, 60.0);
  drive({1.0, 1.0}, 1.0, 120.0);
  EXPECT_LT(translation(), 1.6);
}

TEST_F(MotionNoiseScaleTest, LearnsNothingWhereTheSensorIsMuchWorseThanTheMotion) {
  drive({4.0, 4.0}, 1e4, 20.0);
  EXPECT_NEAR(translation(), 1.0, 1e-3);
}

TEST_F(MotionNoiseScaleTest, DoesNotRunAwayFromOneOutlier) {
  // Of a motion that is measured perfectly, one error of six deviations.
  MotionNoiseScale::Evidence evidence;
  evidence.slope[0] = 0.5 * (36.0 - 1.0);
  evidence.information(0, 0) = 0.5;
  scale_.learn(0.0, evidence);
  EXPECT_GT(translation(), 1.0);
  EXPECT_LT(translation(), 4.0);
}

TEST_F(MotionNoiseScaleTest, LeavesOutWhatIsNotFinite) {
  MotionNoiseScale::Evidence evidence;
  evidence.slope[0] = std::numeric_limits<double>::quiet_NaN();
  evidence.information.setIdentity();
  scale_.learn(1.0, evidence);
  EXPECT_EQ(scale_.factors(), Eigen::Vector2d::Ones());
}

TEST_F(MotionNoiseScaleTest, BelievesTheClaimsForEverWithoutDoubt) {
  MotionNoiseConfig config;
  config.doubt = 0.0;
  scale_ = MotionNoiseScale(config);
  drive({9.0, 9.0}, 1.0, 60.0);
  EXPECT_EQ(scale_.factors(), Eigen::Vector2d::Ones());
}

}  // namespace
}  // namespace hymm::core
