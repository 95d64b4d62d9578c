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
    for (const RegisteredLandmark& landmark : registry.all()) {
      if ((landmark.position - centre).norm() <= radius) expected.push_back(landmark.slot);
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

class TentativeLandmarkTest : public testing::Test {
 protected:
  /// Scans come at 5 Hz.
  bool seenAt(double x, double y, long scan, LandmarkType type = LandmarkType::kTrunk) {
    return tentative_.observe({x, y}, 1e-4 * Matrix2d::Identity(), type, scan,
                              0.2 * static_cast<double>(scan));
  }

  TentativeLandmarks tentative_{{3, 0.3, 1.0, 0.2}};
};

TEST_F(TentativeLandmarkTest, PromotesWhatIsSeenOftenEnoughForLongEnough) {
  EXPECT_FALSE(seenAt(5.0, 0.0, 1));
  EXPECT_FALSE(seenAt(5.1, 0.0, 2));
  EXPECT_FALSE(seenAt(5.0, 0.1, 3));
  EXPECT_TRUE(seenAt(5.0, 0.1, 6));
  EXPECT_EQ(tentative_.size(), 0U);
}

TEST_F(TentativeLandmarkTest, ForgetsWhatIsSeenTooSeldom) {
  for (long scan = 1; scan <= 60; ++scan) {
    if (scan % 5 == 0) {
      EXPECT_FALSE(seenAt(5.0, 0.0, scan)) << scan;
    }
    tentative_.expire(scan);
  }
  tentative_.expire(71);
  EXPECT_EQ(tentative_.size(), 0U);
}

TEST_F(TentativeLandmarkTest, PromotesAtAnyRateOfScans) {
  for (const double rate_hz : {1.0, 5.0, 10.0, 20.0, 50.0}) {
    double promoted_s = -1.0;
    for (long scan = 0; promoted_s < 0.0 && scan < 200; ++scan) {
      const double time_s = static_cast<double>(scan) / rate_hz;
      const bool is_seen = scan % 2 == 0;
      if (is_seen && tentative_.observe({5.0, 0.0}, 1e-4 * Matrix2d::Identity(),
                                        LandmarkType::kTrunk, scan, time_s)) {
        promoted_s = time_s;
      }
      tentative_.expire(scan);
    }
    EXPECT_GE(promoted_s, 1.0) << rate_hz;
    EXPECT_LE(promoted_s, std::max(1.2, 4.0 / rate_hz)) << rate_hz;
  }
}

TEST_F(TentativeLandmarkTest, NeedsTheShareOfScansAtAHighRateToo) {
  for (long scan = 0; scan < 400; ++scan) {
    const double time_s = 0.02 * static_cast<double>(scan);
    if (scan % 4 == 0) {
      EXPECT_FALSE(tentative_.observe({5.0, 0.0}, 1e-4 * Matrix2d::Identity(), LandmarkType::kTrunk,
                                      scan, time_s))
          << time_s;
    }
    tentative_.expire(scan);
  }
}

TEST_F(TentativeLandmarkTest, DoesNotPromoteWhatWalks) {
  for (const double speed_mps : {0.5, 1.0, 1.4, 3.0}) {
    for (long scan = 1; scan <= 40; ++scan) {
      EXPECT_FALSE(seenAt(speed_mps * 0.2 * static_cast<double>(scan), 4.0, scan)) << speed_mps;
      tentative_.expire(scan);
    }
    tentative_.clear();
  }
}

TEST_F(TentativeLandmarkTest, KeepsTypesAndNeighboursOfOneScanApart) {
  EXPECT_FALSE(seenAt(5.0, 0.0, 1));
  EXPECT_FALSE(seenAt(5.1, 0.0, 1));
  EXPECT_FALSE(seenAt(5.0, 0.0, 2, LandmarkType::kReflector));
  EXPECT_EQ(tentative_.size(), 3U);
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

TEST_F(LandmarkVisibility, ExpectsNothingWhereBeamsTellNothing) {
  for (const float mask : {std::numeric_limits<float>::quiet_NaN(), 0.0F}) {
    scan_.ranges_m.assign(361, mask);  // the vehicle's own body, or a cloud without points there
    EXPECT_FALSE(visible({10.0, 2.0})) << mask;
  }
  scan_.ranges_m.assign(361, 82.0F);  // beyond the maximum: nothing there
  EXPECT_TRUE(visible({10.0, 2.0}));
}

TEST_F(LandmarkVisibility, LooksThroughTheBeamThatPassedFromWhereTheLaserWasByThen) {
  // Half a metre ahead by the end of the scan; the landmark, left and near, is then more to the
  // left. What hides it stands where the late beam passes, and not where one of the stamp would.
  const Vector2d position(1.0, 2.5);
  scan_.T_stamp_beam.assign(361, Pose2{0.5, 0.0, 0.0});
  const double late = std::atan2(2.5, 0.5), early = std::atan2(2.5, 1.0);
  const auto beamOf = [&](double bearing) {
    return static_cast<std::size_t>((bearing - scan_.angle_min_rad) / scan_.angle_increment_rad);
  };
  scan_.ranges_m[beamOf(early) - 10] = 1.0F;
  EXPECT_TRUE(visible(position));
  scan_.ranges_m[beamOf(late)] = 1.0F;
  EXPECT_FALSE(visible(position));
}

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

TEST_F(LandmarkVisibility, TakesADiameterBelowZeroForNone) {
  landmark_.diameter_m = -8.0;
  EXPECT_TRUE(visible({10.0, 0.0}));
  scan_.ranges_m[180] = 5.0F;
  EXPECT_FALSE(visible({10.0, 0.0}));
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
