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

}  // namespace
}  // namespace hymm::core
