#include <cmath>
#include <limits>

#include <gmock/gmock.h>

#include "perception/perception.h"
#include "support/analytic_laser.h"

namespace hymm::core {
namespace {

PerceptionConfig reflectorsOnly() {
  PerceptionConfig config;
  config.trunks.enabled = false;
  config.reflectors.enabled = true;
  return config;
}

/// An empty half turn with intensities, all dark.
LaserScan darkScan() {
  LaserScan scan = AnalyticLaser().halfTurn();
  scan.intensities.assign(scan.ranges_m.size(), 0.0F);
  return scan;
}

void setBeam(LaserScan& scan, std::size_t beam, float range_m, float intensity) {
  scan.ranges_m[beam] = range_m;
  scan.intensities[beam] = intensity;
}

TEST(ReflectorDetector, FindsPoleFromBrightBeams) {
  LaserScan scan = darkScan();
  setBeam(scan, 200, 10.0F, 24576.0F);
  setBeam(scan, 201, 10.0F, 8192.0F);
  const auto found = Perception(reflectorsOnly()).detect(scan);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].type, LandmarkType::kReflector);
  EXPECT_NEAR(found[0].bearing_rad, 0.5 * (scan.bearing(200) + scan.bearing(201)), 1e-9);
  // Half a diameter behind the front. Of the 17 cm that are bright, those beams that meet the 6 cm
  // of the pole itself end farther back, on average by the mean depth of a circle.
  const double met = 0.06 / (2.0 * 10.0 * kPi / 360.0);
  EXPECT_NEAR(found[0].range_m, 10.0 + 0.03 * (1.0 - met * (1.0 - kPi / 4.0)), 1e-6);
  EXPECT_TRUE(std::isnan(found[0].diameter_m));
}

TEST(ReflectorDetector, SeparatesPolesAtDifferentRanges) {
  LaserScan scan = darkScan();
  setBeam(scan, 200, 10.0F, 8192.0F);
  setBeam(scan, 201, 12.0F, 8192.0F);
  setBeam(scan, 250, 10.0F, 8192.0F);
  EXPECT_EQ(Perception(reflectorsOnly()).detect(scan).size(), 3U);
}

TEST(ReflectorDetector, IgnoresDarkBeamsAndWideReflectors) {
  LaserScan scan = darkScan();
  setBeam(scan, 100, 10.0F, 8191.0F);
  for (std::size_t beam = 200; beam < 208; ++beam) setBeam(scan, beam, 10.0F, 32768.0F);
  EXPECT_TRUE(Perception(reflectorsOnly()).detect(scan).empty());
}

TEST(ReflectorDetector, IgnoresBrightBeamsWithoutRange) {
  LaserScan scan = darkScan();
  setBeam(scan, 100, std::numeric_limits<float>::infinity(), 32768.0F);
  setBeam(scan, 110, std::numeric_limits<float>::quiet_NaN(), 32768.0F);
  setBeam(scan, 120, 5.0F, std::numeric_limits<float>::quiet_NaN());
  EXPECT_TRUE(Perception(reflectorsOnly()).detect(scan).empty());
}

TEST(ReflectorDetector, FindsNothingInScanWithoutIntensities) {
  EXPECT_TRUE(
      Perception(reflectorsOnly()).detect(AnalyticLaser().trunk(5.0, 0.0, 0.1).halfTurn()).empty());
}

TEST(ReflectorDetector, FindsPoleAcrossTheSeamOfFullTurn) {
  LaserScan scan = AnalyticLaser().scan(-kPi, kPi / 360.0, 720);
  scan.intensities.assign(720, 0.0F);
  setBeam(scan, 0, 4.0F, 9000.0F);
  setBeam(scan, 719, 4.0F, 9000.0F);
  const auto found = Perception(reflectorsOnly()).detect(scan);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(std::abs(found[0].bearing_rad), kPi - 0.25 * kPi / 180.0, 1e-9);
}

TEST(Perception, CallsTrunkThatReflectsAReflector) {
  LaserScan scan = AnalyticLaser().trunk(5.0, 0.0, 0.2).trunk(8.0, 0.5, 0.4).halfTurn();
  scan.intensities.assign(scan.ranges_m.size(), 0.0F);
  for (std::size_t i = 178; i < 183; ++i) {
    if (std::isfinite(scan.ranges_m[i])) scan.intensities[i] = 20000.0F;
  }
  PerceptionConfig config;
  config.reflectors.enabled = true;
  config.reflectors.diameter_m = 0.2;
  const auto found = Perception(config).detect(scan);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].type, LandmarkType::kReflector);
  EXPECT_NEAR(found[0].bearing_rad, 0.0, 0.005);
  EXPECT_EQ(found[1].type, LandmarkType::kTrunk);
  EXPECT_NEAR(found[1].bearing_rad, 0.5, 0.005);
}

}  // namespace
}  // namespace hymm::core
