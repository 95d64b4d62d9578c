#include "evaluation/gps_alignment.h"

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

using Eigen::Vector2d;

const Vector2d kAntenna(3.78, 0.5);
const Pose2 kWorld{300.0, -20.0, 0.6};  // map in the frame of the GPS

/// A car on a circle of 20 m, at 4 m/s.
Pose2 poseAt(double time_s) {
  const double angle = 0.2 * time_s;
  return {20.0 * std::sin(angle), 20.0 * (1.0 - std::cos(angle)), wrapAngle(angle)};
}

GpsFix fixAt(double time_s) {
  GpsFix fix;
  fix.time_s = time_s;
  fix.antenna = kAntenna;
  fix.position = kWorld * (poseAt(time_s) * kAntenna);
  return fix;
}

TEST(GpsAlignment, RotatedTrajectoryWithOffsetAntennaHasNoError) {
  GpsAlignment alignment;
  for (int i = 0; i < 200; ++i) {
    alignment.addPose({0.2 * i, poseAt(0.2 * i)});
    if (i % 5 == 0) alignment.addFix(fixAt(0.2 * i));
  }
  EXPECT_EQ(alignment.count(), 40u);
  ASSERT_TRUE(alignment.rmse());
  EXPECT_NEAR(*alignment.rmse(), 0.0, 1e-5);
}

TEST(GpsAlignment, ComparesFixesBetweenPosesByInterpolation) {
  GpsAlignment alignment;
  alignment.addFix({-1.0, {0.0, 0.0}});  // before the first pose: cannot be compared
  for (int i = 0; i <= 10; ++i) {
    alignment.addPose({1.0 * i, {2.0 * i, 0.0, 0.0}});
    alignment.addFix({i + 0.5, {0.0, 2.0 * i + 1.0}});  // the same line, turned by 90 degrees
  }
  EXPECT_EQ(alignment.count(), 10u);  // the last waits for a pose that never came
  EXPECT_NEAR(*alignment.rmse(), 0.0, 1e-6);
}

TEST(GpsAlignment, EachMapHasItsOwnAlignment) {
  GpsAlignment alignment;
  for (int map = 0; map < 2; ++map) {
    const Pose2 T_map = map == 0 ? Pose2{} : Pose2{50.0, 3.0, 1.0};
    for (int i = 0; i < 100; ++i) {
      alignment.addPose({0.2 * i, T_map * poseAt(0.2 * i)});
      alignment.addFix(fixAt(0.2 * i));
    }
    alignment.startMap();
  }
  EXPECT_EQ(alignment.count(), 200u);
  EXPECT_NEAR(*alignment.rmse(), 0.0, 1e-5);
}

TEST(GpsAlignment, TwoFixesAreNoMeasureOfAnError) {
  GpsAlignment alignment;
  for (int i = 0; i < 2; ++i) {
    alignment.addPose({1.0 * i, {2.0 * i, 0.0, 0.0}});
    alignment.addFix({1.0 * i, {9.0 * i, 0.0}});
  }
  EXPECT_FALSE(alignment.rmse());
}

}  // namespace
}  // namespace hymm::core
