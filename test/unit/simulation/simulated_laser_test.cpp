#include "simulation/simulated_laser.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/chi_square.h"

namespace hymm::core {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

SimulatedLaserConfig perfect() {
  SimulatedLaserConfig config;
  config.range_deviation_m = config.range_deviation_relative = config.range_resolution_m = 0.0;
  config.dark_range_m = 0.0;
  config.missed_return_probability = config.spurious_return_probability = 0.0;
  return config;
}

Solid post(double x, double y, double radius, int landmark = -1) {
  return {Disc{{x, y}, radius}, {}, landmark};
}

Solid reflector(double x, double y, int landmark) {
  return {Disc{{x, y}, 0.03}, {0.9, true, 0.0}, landmark};
}

/// A wall around the origin whose distance from it hardly differs from `radius`.
Solid ring(double radius, double reflectivity = 0.3) {
  return {Disc{{0.0, 0.0}, radius}, {reflectivity, false, 0.0}, -1};
}

std::vector<Disc> discsOf(const std::vector<Solid>& solids) {
  std::vector<Disc> discs;
  for (const Solid& solid : solids) {
    if (solid.material.retro_reflective) discs.push_back(std::get<Disc>(solid.shape));
  }
  return discs;
}

SimulatedScan scanOf(const SimulatedLaserConfig& config, const std::vector<Solid>& standing,
                     const std::vector<Solid>& moving = {}, const Pose2& T_map_laser = {}) {
  const RayCaster caster(standing);
  SimulatedLaser laser(config, RandomGenerator(42));
  const auto view = [&](double) {
    return LaserView{Scene(standing, caster, moving), discsOf(standing), T_map_laser};
  };
  return laser.scan(view, 3.0);
}

TEST(SimulatedLaser, SeesWhatIsOnTheLeftAtPositiveBearing) {
  // One beam every half degree from -90 to 90: the one at +45 degrees has index 270.
  const SimulatedScan result = scanOf(perfect(), {post(7.0, 7.0, 0.3, 5)});
  ASSERT_EQ(result.scan.ranges_m.size(), 361U);
  EXPECT_NEAR(result.scan.bearing(270), kPi / 4.0, 1e-12);
  EXPECT_NEAR(result.scan.ranges_m[270], std::hypot(7.0, 7.0) - 0.3, 1e-5);
  EXPECT_EQ(result.beam_landmarks[270], 5);
  EXPECT_EQ(result.scan.ranges_m[90], kInfinity);
  EXPECT_EQ(result.beam_landmarks[90], -1);
  EXPECT_EQ(result.scan.time_s, 3.0);
}

TEST(SimulatedLaser, TurnsAndMovesWithItsMounting) {
  const SimulatedScan result = scanOf(perfect(), {post(1.0, 12.0, 0.3)}, {}, {1.0, 2.0, kPi / 2.0});
  EXPECT_NEAR(result.scan.ranges_m[180], 9.7, 1e-5);
}

TEST(SimulatedLaser, SpreadsItsBeamsOverAWholeTurnWithoutRepeatingOne) {
  SimulatedLaserConfig config = perfect();
  config.field_of_view_rad = 2.0 * kPi;
  config.beams = 720;
  const LaserScan scan = scanOf(config, {ring(10.0)}).scan;
  EXPECT_NEAR(scan.angle_increment_rad, 2.0 * kPi / 720, 1e-12);
  EXPECT_NEAR(scan.bearing(0), -kPi, 1e-12);
  EXPECT_NEAR(scan.bearing(719), kPi - scan.angle_increment_rad, 1e-12);
  for (const float range : scan.ranges_m) EXPECT_NEAR(range, 10.0, 1e-4);
}

TEST(SimulatedLaser, SeesNothingBehindWhatStandsOrMoves) {
  const std::vector<Solid> trees = {post(20.0, 0.0, 0.2, 0), post(0.0, 20.0, 0.2, 1)};
  const std::vector<Solid> passing = {post(8.0, 0.0, 0.5)};
  const SimulatedScan result = scanOf(perfect(), trees, passing);
  EXPECT_NEAR(result.scan.ranges_m[180], 7.5, 1e-5);
  EXPECT_THAT(result.beam_landmarks, testing::Not(testing::Contains(0)));
  EXPECT_THAT(result.beam_landmarks, testing::Contains(1));
}

TEST(SimulatedLaser, ReportsTooNearAndTooFarAsRep117Says) {
  SimulatedLaserConfig config = perfect();
  config.range_min_m = 1.0;
  config.range_max_m = 5.0;
  EXPECT_THAT(scanOf(config, {ring(0.5)}).scan.ranges_m, testing::Each(-kInfinity));
  EXPECT_THAT(scanOf(config, {ring(5.5)}).scan.ranges_m, testing::Each(kInfinity));
}

TEST(SimulatedLaser, HasTheRangeNoiseThatItsConfigurationStates) {
  SimulatedLaserConfig config = perfect();
  config.beams = 4000;
  config.range_deviation_m = 0.03;
  config.range_deviation_relative = 0.002;
  const double deviation = std::hypot(0.03, 0.002 * 20.0);
  double sum = 0.0;
  for (const float range : scanOf(config, {ring(20.0)}).scan.ranges_m) {
    sum += std::pow((static_cast<double>(range) - 20.0) / deviation, 2);
  }
  EXPECT_GT(sum, chiSquareQuantile(0.0005, 4000));
  EXPECT_LT(sum, chiSquareQuantile(0.9995, 4000));
}

TEST(SimulatedLaser, MeasuresTooLongByItsOffset) {
  SimulatedLaserConfig config = perfect();
  config.range_offset_m = 0.05;
  EXPECT_NEAR(scanOf(config, {ring(20.0)}).scan.ranges_m[180], 20.05, 1e-3);
}

TEST(SimulatedLaser, RoundsRangesToItsResolution) {
  SimulatedLaserConfig config = perfect();
  config.range_deviation_m = 0.05;
  config.range_resolution_m = 0.01;
  for (const float range : scanOf(config, {ring(10.0)}).scan.ranges_m) {
    const double steps = static_cast<double>(range) / 0.01;
    EXPECT_NEAR(steps, std::round(steps), 1e-3);
  }
}

/// Share of beams that return nothing.
double missedShare(const SimulatedLaserConfig& config, const Solid& target) {
  const auto ranges = scanOf(config, {target}).scan.ranges_m;
  return static_cast<double>(std::count(ranges.begin(), ranges.end(), kInfinity)) /
         static_cast<double>(ranges.size());
}

TEST(SimulatedLaser, MissesDarkTargetsHalfTheTimeAtItsDarkRange) {
  SimulatedLaserConfig config = perfect();
  config.beams = 4000;
  config.dark_range_m = 30.0;
  const double four_sigma = 4.0 * 0.5 / std::sqrt(4000.0);
  EXPECT_NEAR(missedShare(config, ring(30.0, 0.1)), 0.5, four_sigma);
  EXPECT_LT(missedShare(config, ring(10.0, 0.1)), 0.01);
  EXPECT_GT(missedShare(config, ring(70.0, 0.1)), 0.95);
  EXPECT_LT(missedShare(config, ring(30.0, 0.4)), 0.02);
}

TEST(SimulatedLaser, MissesSurfacesThatItGrazes) {
  SimulatedLaserConfig config = perfect();
  config.dark_range_m = 30.0;
  const Solid wall{makeWall({0.0, -1.0}, {79.0, -1.0}, 0.1), {0.4, false, 0.0}, -1};
  const auto ranges = scanOf(config, {wall}).scan.ranges_m;
  EXPECT_LT(ranges[0], 1.0);  // square on
  // From 50 m on the wall is met at about one degree.
  EXPECT_THAT(std::vector<float>(ranges.begin() + 176, ranges.begin() + 180),
              testing::Each(kInfinity));
}

TEST(SimulatedLaser, MissesAndInventsReturnsAsOftenAsConfigured) {
  SimulatedLaserConfig config = perfect();
  config.beams = 20000;
  config.missed_return_probability = 0.05;
  EXPECT_NEAR(missedShare(config, ring(10.0)), 0.05, 4.0 * std::sqrt(0.05 * 0.95 / 20000.0));
  config.missed_return_probability = 0.0;
  config.spurious_return_probability = 0.02;
  int spurious = 0;
  for (const float range : scanOf(config, {ring(10.0)}).scan.ranges_m) {
    EXPECT_LE(range, 10.001F);
    if (range < 9.99F) ++spurious;
  }
  EXPECT_NEAR(spurious / 20000.0, 0.02, 4.0 * std::sqrt(0.02 * 0.98 / 20000.0));
}

TEST(SimulatedLaser, SeesAReflectorThatStandsBetweenItsBeams) {
  // At 30 m beams are 26 cm apart and the post is 6 cm wide.
  const double between = 0.25 * kPi / 180.0;
  const std::vector<Solid> world = {
      reflector(30.0 * std::cos(between), 30.0 * std::sin(between), 0)};
  EXPECT_THAT(scanOf(perfect(), world).beam_landmarks, testing::Contains(0));
  SimulatedLaserConfig pencil = perfect();
  pencil.beam_width_rad = 0.0;
  EXPECT_THAT(scanOf(pencil, world).beam_landmarks, testing::Not(testing::Contains(0)));
}

TEST(SimulatedLaser, SeesNoReflectorThroughAWall) {
  const std::vector<Solid> world = {reflector(30.0, 0.0, 0), post(15.0, 0.0, 0.4)};
  EXPECT_THAT(scanOf(perfect(), world).beam_landmarks, testing::Not(testing::Contains(0)));
}

TEST(SimulatedLaser, GivesBrightIntensitiesToReflectorsOnly) {
  const std::vector<Solid> world = {reflector(12.0, 0.0, 0), post(5.0, 6.0, 0.5), ring(25.0)};
  const SimulatedScan result = scanOf(perfect(), world);
  for (std::size_t i = 0; i < result.scan.intensities.size(); ++i) {
    if (result.beam_landmarks[i] == 0) {
      EXPECT_GE(result.scan.intensities[i], 8192.0F);
    } else {
      EXPECT_LT(result.scan.intensities[i], 8192.0F);
    }
  }
}

TEST(SimulatedLaser, MixesRangesAtEdgesIfAskedTo) {
  SimulatedLaserConfig config = perfect();
  config.mixed_pixel_probability = 1.0;
  const std::vector<Solid> world = {post(10.0, 0.0, 0.5), ring(20.0)};
  int mixed = 0;
  for (const float range : scanOf(config, world).scan.ranges_m) {
    if (range > 10.1F && range < 19.9F) ++mixed;
  }
  EXPECT_GE(mixed, 1);
  EXPECT_LE(mixed, 2);  // one at each side of the post
}

TEST(SimulatedLaser, CastsEachBeamAtItsTimeIfItRotates) {
  // Through a round place at 5 m/s: each beam ends on its wall from where the laser is by then, to
  // the half millimetre that beams of one group are apart.
  SimulatedLaserConfig config = perfect();
  config.rotating = true;
  config.rate_hz = 10.0;
  const std::vector<Solid> world = {ring(50.0)};
  const RayCaster caster(world);
  SimulatedLaser laser(config, RandomGenerator(42));
  EXPECT_NEAR(laser.sweep_s(), 0.05, 1e-12);  // half a turn
  const auto view = [&](double time_s) {
    const Pose2 T_map_laser{5.0 * (time_s - 3.0), 0.0, 0.0};
    return LaserView{Scene(world, caster, {}), {}, T_map_laser};
  };
  const LaserScan scan = laser.scan(view, 3.0).scan;
  EXPECT_NEAR(scan.time_increment_s, 0.05 / 360.0, 1e-12);
  EXPECT_EQ(scan.time_s, 3.0);
  for (const std::size_t i : {0U, 90U, 180U, 300U, 360U}) {
    SCOPED_TRACE(i);
    const double moved_m = 5.0 * static_cast<double>(i) * scan.time_increment_s;
    const double range_m = static_cast<double>(scan.ranges_m[i]);
    const Eigen::Vector2d end(moved_m + range_m * std::cos(scan.bearing(i)),
                              range_m * std::sin(scan.bearing(i)));
    EXPECT_NEAR(end.norm(), 50.0, 1e-3);
  }
}

}  // namespace
}  // namespace hymm::core
