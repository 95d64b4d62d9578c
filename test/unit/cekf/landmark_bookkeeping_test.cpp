#include <algorithm>
#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cekf/landmark_registry.h"
#include "cekf/landmark_visibility.h"
#include "cekf/tentative_landmarks.h"
#include "common/random.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

RegisteredLandmark landmarkAt(int id, const Vector2d& position) {
  RegisteredLandmark landmark;
  landmark.id = id;
  landmark.slot = 100 + id;
  landmark.position = position;
  landmark.farthest_seen_m = 30.0;
  landmark.diameter_m = 0.3;
  return landmark;
}

TEST(LandmarkRegistry, FindsExactlyWhatIsNear) {
  RandomGenerator generator(1);
  LandmarkRegistry registry;
  for (int id = 0; id < 400; ++id) {
    registry.add(landmarkAt(
        id, {sampleUniform(generator, -50.0, 50.0), sampleUniform(generator, -50.0, 50.0)}));
  }
  for (int id = 0; id < 400; id += 3) {
    registry.move(registry.byId(id), registry.byId(id).position + Vector2d(5.0, -3.0));
  }
  const Vector2d centre(3.0, -8.0);
  for (const double radius : {0.5, 4.0, 17.0}) {
    std::vector<int> expected;
    for (const int id : registry.ids()) {
      if ((registry.byId(id).position - centre).norm() <= radius) expected.push_back(100 + id);
    }
    EXPECT_EQ(registry.slotsNear(centre, radius), expected);
  }
}

TEST(LandmarkRegistry, ForgetsWhatLeft) {
  LandmarkRegistry registry;
  RegisteredLandmark landmark = landmarkAt(4, {1.0, 1.0});
  landmark.identity = 77;
  registry.add(landmark);
  ASSERT_NE(registry.findIdentity(77), nullptr);
  registry.remove(4);
  EXPECT_EQ(registry.findIdentity(77), nullptr);
  EXPECT_TRUE(registry.slotsNear({1.0, 1.0}, 10.0).empty());
  EXPECT_EQ(registry.size(), 0U);
}

TEST(TentativeLandmarks, PromotesWhatIsSeenOftenEnough) {
  TentativeLandmarks tentative({3, 6, 0.5});
  const Matrix2d covariance = 1e-4 * Matrix2d::Identity();
  EXPECT_FALSE(tentative.observe({5.0, 0.0}, covariance, LandmarkType::kTrunk, 1));
  EXPECT_FALSE(tentative.observe({5.1, 0.0}, covariance, LandmarkType::kTrunk, 3));
  EXPECT_TRUE(tentative.observe({5.0, 0.1}, covariance, LandmarkType::kTrunk, 5));
  EXPECT_EQ(tentative.size(), 0U);
}

TEST(TentativeLandmarks, ForgetsWhatIsSeenTooSeldom) {
  TentativeLandmarks tentative({3, 4, 0.5});
  const Matrix2d covariance = 1e-4 * Matrix2d::Identity();
  for (long scan = 1; scan <= 40; scan += 3) {
    EXPECT_FALSE(tentative.observe({5.0, 0.0}, covariance, LandmarkType::kTrunk, scan)) << scan;
  }
  tentative.expire(100);
  EXPECT_EQ(tentative.size(), 0U);
}

TEST(TentativeLandmarks, DoesNotPromoteWhatWalks) {
  TentativeLandmarks tentative({3, 6, 0.3});
  const Matrix2d covariance = 1e-6 * Matrix2d::Identity();
  for (long scan = 1; scan <= 20; ++scan) {
    const Vector2d walker(0.35 * static_cast<double>(scan), 4.0);
    EXPECT_FALSE(tentative.observe(walker, covariance, LandmarkType::kTrunk, scan));
  }
}

TEST(TentativeLandmarks, KeepsTypesAndNeighboursOfOneScanApart) {
  TentativeLandmarks tentative({2, 6, 0.5});
  const Matrix2d covariance = 1e-4 * Matrix2d::Identity();
  EXPECT_FALSE(tentative.observe({5.0, 0.0}, covariance, LandmarkType::kTrunk, 1));
  EXPECT_FALSE(tentative.observe({5.1, 0.0}, covariance, LandmarkType::kTrunk, 1));
  EXPECT_FALSE(tentative.observe({5.0, 0.0}, covariance, LandmarkType::kReflector, 2));
  EXPECT_EQ(tentative.size(), 3U);
}

class LandmarkVisibility : public testing::Test {
 protected:
  LandmarkVisibility() {
    scan_.angle_min_rad = -kPi / 2.0;
    scan_.angle_increment_rad = kPi / 360.0;
    scan_.range_max_m = 80.0;
    scan_.ranges_m.assign(361, std::numeric_limits<float>::infinity());
  }

  bool visible(const Vector2d& position) const {
    return shouldBeVisible(scan_, position, landmark_, config_);
  }

  LaserScan scan_;
  RegisteredLandmark landmark_ = landmarkAt(0, {0.0, 0.0});
  LandmarkConfig config_;
};

TEST_F(LandmarkVisibility, ExpectsWhatStandsFreelyInView) { EXPECT_TRUE(visible({10.0, 2.0})); }

TEST_F(LandmarkVisibility, ExpectsNothingBehindOrFarAway) {
  EXPECT_FALSE(visible({-10.0, 0.0}));
  EXPECT_FALSE(visible({0.1, 10.0}));
  EXPECT_FALSE(visible({26.0, 0.0}));
}

TEST_F(LandmarkVisibility, ExpectsNothingBeyondWhereItWasEverSeen) {
  landmark_.farthest_seen_m = 8.0;
  EXPECT_FALSE(visible({10.0, 0.0}));
  EXPECT_TRUE(visible({6.0, 0.0}));
}

TEST_F(LandmarkVisibility, ExpectsNothingBehindANearerThing) {
  scan_.ranges_m[180] = 5.0F;
  EXPECT_FALSE(visible({10.0, 0.0}));
  EXPECT_TRUE(visible({4.0, 0.0}));
  EXPECT_TRUE(visible({10.0, 3.0}));
}

TEST_F(LandmarkVisibility, UnderstandsScansInEitherDirection) {
  scan_.angle_min_rad = kPi / 2.0;
  scan_.angle_increment_rad = -kPi / 360.0;
  EXPECT_TRUE(visible({10.0, 2.0}));
  EXPECT_FALSE(visible({-10.0, 0.0}));
}

}  // namespace
}  // namespace hymm::core
