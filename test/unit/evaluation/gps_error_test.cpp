#include "evaluation/gps_error.h"

#include <limits>

#include <gtest/gtest.h>

#include "evaluation/gps_alignment.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const TimeWindow kAlways{-kInfinity, kInfinity};
const Vector2d kAntenna(3.78, 0.5);
const Pose2 kGpsMap{300.0, -20.0, 0.6};

/// A car on a circle of 20 m at 4 m/s, a pose every 0.2 s for 40 s.
std::vector<StampedPose> circle() {
  std::vector<StampedPose> poses;
  for (int i = 0; i <= 200; ++i) {
    const double angle = 0.04 * i;
    poses.push_back(
        {0.2 * i, {20.0 * std::sin(angle), 20.0 * (1.0 - std::cos(angle)), wrapAngle(angle)}});
  }
  return poses;
}

/// What a perfect receiver says once a second.
std::vector<StampedPosition> perfectFixes(const Vector2d& antenna) {
  std::vector<StampedPosition> fixes;
  const auto poses = circle();
  for (std::size_t i = 0; i < poses.size(); i += 5) {
    fixes.push_back({poses[i].time_s, kGpsMap * (poses[i].pose * antenna)});
  }
  return fixes;
}

TEST(GpsErrors, RotatedTrajectoryHasNoError) {
  const auto errors =
      computeGpsErrors(Trajectory(circle()), perfectFixes(kAntenna), kAntenna, kAlways);
  ASSERT_TRUE(errors);
  EXPECT_EQ(errors->distance_m.count, 41u);
  EXPECT_NEAR(errors->distance_m.max, 0.0, 1e-12 * 300.0);
  EXPECT_NEAR(errors->T_gps_map.x_m, 300.0, 1e-10);
  EXPECT_NEAR(errors->T_gps_map.y_m, -20.0, 1e-10);
  EXPECT_NEAR(errors->T_gps_map.yaw_rad, 0.6, 1e-12);
}

TEST(GpsErrors, WrongAntennaShows) {
  // Over a straight line an offset along it is a translation; on a circle it turns with the car.
  const auto errors =
      computeGpsErrors(Trajectory(circle()), perfectFixes(kAntenna), {0.0, 0.0}, kAlways);
  ASSERT_TRUE(errors);
  EXPECT_GT(errors->distance_m.rmse, 0.1);
}

TEST(GpsErrors, FixThatCannotBeReachedIsLeftOut) {
  auto fixes = perfectFixes(kAntenna);
  fixes[20].position += Vector2d(30.0, 0.0);
  const auto errors = computeGpsErrors(Trajectory(circle()), fixes, kAntenna, kAlways);
  ASSERT_TRUE(errors);
  EXPECT_EQ(errors->unreachable, 1u);
  EXPECT_EQ(errors->distance_m.count, 40u);
  EXPECT_NEAR(errors->distance_m.max, 0.0, 1e-10);
}

TEST(GpsErrors, KnownErrorIsMeasured) {
  // Fixes displaced alternately along and against x by 0.5 m: no rigid motion can follow.
  std::vector<StampedPose> line;
  std::vector<StampedPosition> fixes;
  for (int i = 0; i < 1000; ++i) {
    line.push_back({1.0 * i, {2.0 * i, 0.0, 0.0}});
    fixes.push_back({1.0 * i, {2.0 * i + (i % 2 == 0 ? 0.5 : -0.5), 0.0}});
  }
  const auto errors = computeGpsErrors(Trajectory(line), fixes, {0.0, 0.0}, kAlways);
  ASSERT_TRUE(errors);
  EXPECT_NEAR(errors->distance_m.rmse, 0.5, 1e-9);
  EXPECT_NEAR(errors->distance_m.median, 0.5, 1e-9);
  EXPECT_NEAR(errors->distance_m.max, 0.5, 1e-9);
}

TEST(GpsErrors, WindowHasItsOwnAlignment) {
  auto fixes = perfectFixes(kAntenna);
  for (auto& fix : fixes) {
    if (fix.time_s > 20.0) fix.position += Vector2d(8.0, 0.0);  // the filter slipped by then
  }
  const Trajectory trajectory(circle());
  EXPECT_GT(computeGpsErrors(trajectory, fixes, kAntenna, kAlways)->distance_m.rmse, 1.0);
  const auto late = computeGpsErrors(trajectory, fixes, kAntenna, {20.5, kInfinity});
  ASSERT_TRUE(late);
  EXPECT_EQ(late->distance_m.count, 20u);
  EXPECT_NEAR(late->distance_m.max, 0.0, 1e-10);
}

TEST(GpsErrors, WindowWithoutFixesHasNone) {
  EXPECT_FALSE(
      computeGpsErrors(Trajectory(circle()), perfectFixes(kAntenna), kAntenna, {600.0, kInfinity}));
}

TEST(GpsErrors, EqualsTheErrorThatARunStatesOfItself) {
  auto fixes = perfectFixes(kAntenna);
  for (StampedPosition& fix : fixes) fix.position.x() += 0.3 * std::sin(7.0 * fix.time_s);
  GpsAlignment running;
  std::size_t next = 0;
  for (const StampedPose& pose : circle()) {
    for (; next < fixes.size() && fixes[next].time_s <= pose.time_s; ++next) {
      running.addFix({fixes[next].time_s, fixes[next].position, {}, kAntenna});
    }
    running.addPose(pose);
  }
  const auto errors = computeGpsErrors(Trajectory(circle()), fixes, kAntenna, kAlways);
  EXPECT_EQ(running.count(), errors->distance_m.count);
  EXPECT_NEAR(*running.rmse(), errors->distance_m.rmse, 1e-6);
}

}  // namespace
}  // namespace hymm::core
