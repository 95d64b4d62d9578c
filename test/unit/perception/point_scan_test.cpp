#include "perception/point_scan.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "common/angles.h"
#include "perception/scan_check.h"

namespace hymm::core {
namespace {

LaserScan scanOf(const std::vector<Eigen::Vector3f>& points) {
  return scanOfPoints(points, 7.0, PointCloudConfig());
}

float rangeTowards(const LaserScan& scan, double bearing_rad) {
  const long direction = std::lround((bearing_rad - scan.angle_min_rad) / scan.angle_increment_rad);
  return scan.ranges_m[static_cast<std::size_t>(direction) % scan.ranges_m.size()];
}

TEST(PointScan, EachDirectionShowsItsNearestPoint) {
  const LaserScan scan = scanOf({{9.0F, 9.0F, 1.0F}, {3.0F, 3.0F, 0.5F}, {-4.0F, 0.01F, 1.2F}});
  EXPECT_FALSE(scanProblem(scan).has_value());
  EXPECT_EQ(scan.time_s, 7.0);
  EXPECT_NEAR(rangeTowards(scan, kPi / 4.0), std::hypot(3.0, 3.0), 1e-5);
  EXPECT_NEAR(scan.ranges_m.front(), 4.0, 1e-4);  // straight back
}

TEST(PointScan, EachPointFallsIntoTheDirectionThatIsNearest) {
  for (double bearing = -3.14; bearing <= 3.14; bearing += 0.01) {
    const LaserScan scan = scanOf({{static_cast<float>(5.0 * std::cos(bearing)),
                                    static_cast<float>(5.0 * std::sin(bearing)), 1.0F}});
    EXPECT_NEAR(rangeTowards(scan, bearing), 5.0, 1e-5) << bearing;
  }
}

TEST(PointScan, PointsOfASensorWithAsManyDirectionsFillEach) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 720; ++i) {
    const double bearing = i * kPi / 360.0;
    points.emplace_back(static_cast<float>(7.0 * std::cos(bearing)),
                        static_cast<float>(7.0 * std::sin(bearing)), 1.0F);
  }
  for (const float range_m : scanOf(points).ranges_m) EXPECT_NEAR(range_m, 7.0F, 1e-5F);
}

TEST(PointScan, GroundAndCanopyAreFreeSpace) {
  const LaserScan scan = scanOf({{5.0F, 0.0F, 0.1F}, {0.0F, 5.0F, 2.5F}, {0.0F, -90.0F, 1.0F}});
  for (const double bearing : {0.0, 0.5 * kPi, -0.5 * kPi}) {
    EXPECT_EQ(rangeTowards(scan, bearing), std::numeric_limits<float>::infinity());
  }
}

TEST(PointScan, AnObstacleBehindGroundOrUnderCanopyIsSeen) {
  const LaserScan scan = scanOf({{5.0F, 0.0F, 0.1F}, {8.0F, 0.0F, 1.0F}, {2.0F, 0.0F, 2.5F}});
  EXPECT_NEAR(rangeTowards(scan, 0.0), 8.0, 1e-5);
}

TEST(PointScan, WhereNothingWasMeasuredNothingIsSaid) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const LaserScan scan = scanOf({{nan, 1.0F, 1.0F}, {1.0F, 1.0F, nan}, {0.3F, -0.2F, 1.0F}});
  for (const float range_m : scan.ranges_m) EXPECT_TRUE(std::isnan(range_m));
}

/// Points 6 m away, one each degree, of a laser that turns once in 0.1 s.
struct Turn {
  std::vector<Eigen::Vector3f> points;
  std::vector<float> times_s;

  Turn(double first_rad, double turn_rad) {
    for (int i = 0; i < 360; ++i) {
      const double bearing = first_rad + turn_rad * i / 360.0;
      points.emplace_back(static_cast<float>(6.0 * std::cos(bearing)),
                          static_cast<float>(6.0 * std::sin(bearing)), 1.0F);
      times_s.push_back(0.1F * static_cast<float>(i) / 360.0F);
    }
  }
};

TEST(PointScan, EachBeamHasTheTimeOfThePointThatItShows) {
  for (const double turn : {2.0 * kPi, -2.0 * kPi}) {
    const Turn seen(0.7, turn);
    const LaserScan scan = scanOfPoints(seen.points, 7.0, PointCloudConfig(), seen.times_s);
    ASSERT_EQ(scan.beam_times_s.size(), scan.ranges_m.size());
    EXPECT_FALSE(scanProblem(scan).has_value());
    EXPECT_NEAR(scan.sweep_s(), 0.1, 0.001);
    int measured = 0;
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
      if (std::isnan(scan.ranges_m[i])) continue;
      ++measured;
      double share = (scan.bearing(i) - 0.7) / turn;
      share -= std::floor(share + 0.5 / 720.0);
      EXPECT_NEAR(scan.beamTime_s(i), 0.1 * share, 0.1 / 700.0) << i;
    }
    EXPECT_EQ(measured, 360);
  }
}

TEST(PointScan, BeginsWhereTheTurnDoes) {
  // Nothing but the seam keeps neighbours apart: what stands ahead is one shape.
  const Turn seen(0.7, -2.0 * kPi);
  const LaserScan scan = scanOfPoints(seen.points, 7.0, PointCloudConfig(), seen.times_s);
  ASSERT_EQ(scan.beam_times_s.size(), 720U);
  for (std::size_t i = 1; i < scan.beam_times_s.size(); ++i) {
    EXPECT_LE(std::abs(scan.beam_times_s[i] - scan.beam_times_s[i - 1]), 0.001F) << i;
  }
  EXPECT_NEAR(rangeTowards(scan, 0.7 + 2.0 * kPi), 6.0, 1e-5);
}

TEST(PointScan, ShowsTheTimeOfTheNearestOfSeveralPointsInADirection) {
  const LaserScan scan = scanOfPoints({{9.0F, 0.0F, 1.0F}, {4.0F, 0.0F, 1.0F}, {6.0F, 0.0F, 1.0F}},
                                      7.0, PointCloudConfig(), {0.01F, 0.02F, 0.03F});
  EXPECT_NEAR(scan.sweep_s(), 0.02, 1e-6);
}

TEST(PointScan, WithoutTimesHasNone) {
  EXPECT_TRUE(scanOf({{5.0F, 0.0F, 1.0F}}).beam_times_s.empty());
  EXPECT_TRUE(scanOfPoints({{0.1F, 0.0F, 1.0F}}, 7.0, PointCloudConfig(), {0.01F})
                  .beam_times_s.empty());  // of the vehicle
}

}  // namespace
}  // namespace hymm::core
