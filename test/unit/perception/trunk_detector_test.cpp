#include <array>
#include <cmath>
#include <limits>

#include <gmock/gmock.h>

#include "common/error.h"
#include "common/gaussian.h"
#include "perception/perception.h"
#include "perception/scan_check.h"
#include "support/analytic_laser.h"

namespace hymm::core {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

std::vector<Observation> detect(const LaserScan& scan) {
  return Perception(PerceptionConfig{}).detect(scan);
}

std::size_t beamAt(const LaserScan& scan, double bearing_rad) {
  return static_cast<std::size_t>(
      std::lround((bearing_rad - scan.angle_min_rad) / scan.angle_increment_rad));
}

/// Expects one trunk, where it is and as thick as it is, within what geometry allows: half a beam
/// to each side.
void expectTrunk(const std::vector<Observation>& found, double range_m, double bearing_rad,
                 double diameter_m) {
  ASSERT_EQ(found.size(), 1U);
  const double beam_m = range_m * kPi / 360.0;
  EXPECT_EQ(found[0].type, LandmarkType::kTrunk);
  EXPECT_NEAR(found[0].range_m, range_m, 0.5 * beam_m + 0.01);
  EXPECT_NEAR(wrapAngle(found[0].bearing_rad - bearing_rad), 0.0, 0.5 * kPi / 360.0);
  EXPECT_NEAR(found[0].diameter_m, diameter_m, beam_m);
}

TEST(TrunkDetector, FindsTrunkAtEachRange) {
  for (double range_m = 1.5; range_m <= 30.0; range_m += 0.5) {
    SCOPED_TRACE(range_m);
    expectTrunk(detect(AnalyticLaser().trunk(range_m, 0.3, 0.6).halfTurn()), range_m, 0.3, 0.6);
  }
}

TEST(TrunkDetector, ReportsTrunksByBearing) {
  const auto found = detect(
      AnalyticLaser().trunk(8.0, 1.0, 0.4).trunk(12.0, -1.0, 0.5).trunk(5.0, 0.0, 0.3).halfTurn());
  ASSERT_EQ(found.size(), 3U);
  EXPECT_NEAR(found[0].bearing_rad, -1.0, 0.005);
  EXPECT_NEAR(found[1].bearing_rad, 0.0, 0.005);
  EXPECT_NEAR(found[2].bearing_rad, 1.0, 0.005);
}

TEST(TrunkDetector, LeavesOutTrunkThatIsPartlyHidden) {
  expectTrunk(detect(AnalyticLaser().trunk(6.0, 0.0, 0.4).trunk(10.0, 0.04, 0.6).halfTurn()), 6.0,
              0.0, 0.4);
}

TEST(TrunkDetector, FindsTrunkBeforeWall) {
  expectTrunk(detect(AnalyticLaser().trunk(6.0, 0.1, 0.4).wall(9.0, -30.0, 9.0, 30.0).halfTurn()),
              6.0, 0.1, 0.4);
}

TEST(TrunkDetector, LeavesOutTrunkThatTouchesWall) {
  EXPECT_TRUE(
      detect(AnalyticLaser().disc(6.0, 0.0, 0.4).wall(6.1, -30.0, 6.1, 30.0).halfTurn()).empty());
}

TEST(TrunkDetector, SeesNoTrunkInWallEnds) {
  // Walls from face-on to nearly edge-on, in steps that meet the beams at all phases.
  for (int turn = -88; turn <= 88; turn += 2) {
    SCOPED_TRACE(turn);
    const double angle = turn * kPi / 180.0;
    const double dx = 4.0 * std::sin(angle), dy = 4.0 * std::cos(angle);
    EXPECT_TRUE(detect(AnalyticLaser().wall(10.0 - dx, -dy, 10.0 + dx, dy).halfTurn()).empty());
  }
}

TEST(TrunkDetector, SeesNoTrunkInBoxCorner) {
  EXPECT_TRUE(
      detect(AnalyticLaser().wall(8.0, 0.0, 10.0, 2.0).wall(8.0, 0.0, 10.0, -2.0).halfTurn())
          .empty());
}

TEST(TrunkDetector, SeesNoTrunkInNarrowPieceOfWallBetweenTrunks) {
  const auto found = detect(AnalyticLaser()
                                .disc(5.0, -0.35, 0.4)
                                .disc(5.0, 0.35, 0.4)
                                .wall(9.0, -9.0, 9.0, 9.0)
                                .halfTurn());
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(found[0].range_m, 5.01, 0.05);
  EXPECT_NEAR(found[1].range_m, 5.01, 0.05);
}

TEST(TrunkDetector, LeavesOutShapeOnTheBorderOfTheFieldOfView) {
  EXPECT_TRUE(detect(AnalyticLaser().trunk(6.0, kPi / 2.0, 0.4).halfTurn()).empty());
  EXPECT_TRUE(detect(AnalyticLaser().trunk(6.0, -kPi / 2.0, 0.4).halfTurn()).empty());
}

TEST(TrunkDetector, LeavesOutWhatIsTooThickOrTooThin) {
  EXPECT_TRUE(detect(AnalyticLaser().trunk(6.0, 0.0, 1.4).halfTurn()).empty());
  EXPECT_TRUE(detect(AnalyticLaser().trunk(2.0, 0.002, 0.04).halfTurn()).empty());
}

TEST(TrunkDetector, LeavesOutTrunksBeyondTheLargestRange) {
  PerceptionConfig config;
  config.trunks.max_range_m = 10.0;
  const Perception perception(config);
  EXPECT_EQ(perception.detect(AnalyticLaser().trunk(9.9, 0.0, 0.5).halfTurn()).size(), 1U);
  EXPECT_TRUE(perception.detect(AnalyticLaser().trunk(10.2, 0.0, 0.5).halfTurn()).empty());
}

TEST(TrunkDetector, LeavesOutHollowShape) {
  // A corner seen from inside, half a metre wide, in front of nothing.
  EXPECT_TRUE(detect(AnalyticLaser().wall(3.0, -0.3, 3.3, 0.0).wall(3.3, 0.0, 3.0, 0.3).halfTurn())
                  .empty());
}

TEST(TrunkDetector, TakesSingleBeamOnlyIfConfigured) {
  LaserScan scan = AnalyticLaser().halfTurn();
  scan.ranges_m[100] = 20.0F;
  EXPECT_TRUE(detect(scan).empty());
  PerceptionConfig config;
  config.trunks.min_beams = 1;
  const auto found = Perception(config).detect(scan);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].bearing_rad, scan.bearing(100), 1e-9);
  // One beam wide, give or take what a single beam can hide: spacing squared / 6.
  EXPECT_NEAR(found[0].diameter_m, 20.0 * kPi / 360.0, 0.01);
  EXPECT_NEAR(std::sqrt(found[0].diameter_variance), 20.0 * kPi / 360.0 / std::sqrt(6.0), 0.01);
}

TEST(TrunkDetector, BridgesMissedBeam) {
  for (const float missing : {kInf, kNan, -1.0F, 0.0F}) {
    SCOPED_TRACE(missing);
    LaserScan scan = AnalyticLaser().trunk(5.0, 0.0, 0.5).halfTurn();
    scan.ranges_m[beamAt(scan, 0.0)] = missing;
    expectTrunk(detect(scan), 5.0, 0.0, 0.5);
  }
}

TEST(TrunkDetector, LeavesOutShapeBesideSomethingTooNearToMeasure) {
  const LaserScan clean = AnalyticLaser().trunk(5.0, 0.0, 0.5).halfTurn();
  std::size_t miss = beamAt(clean, 0.0);
  while (std::isfinite(clean.ranges_m[miss])) ++miss;
  LaserScan scan = clean;
  scan.ranges_m[miss] = -kInf;
  EXPECT_EQ(detect(clean).size(), 1U);
  EXPECT_TRUE(detect(scan).empty());
}

TEST(TrunkDetector, WidensVarianceWhereTheEdgeIsUnknown) {
  const LaserScan clean = AnalyticLaser().trunk(15.0, 0.0, 0.5).halfTurn();
  std::size_t miss = beamAt(clean, 0.0);
  while (std::isfinite(clean.ranges_m[miss])) ++miss;
  LaserScan scan = clean;
  scan.ranges_m[miss] = kNan;
  PerceptionConfig config;
  config.laser.bearing_offset_deviation_rad = 0.0;
  config.trunks.surface_deviation = 0.0;
  config.trunks.outline_deviation = 0.0;
  const Perception perception(config);
  const auto known = perception.detect(clean), unknown = perception.detect(scan);
  ASSERT_EQ(known.size(), 1U);
  ASSERT_EQ(unknown.size(), 1U);
  EXPECT_GT(unknown[0].covariance(1, 1), 1.5 * known[0].covariance(1, 1));
}

TEST(TrunkDetector, FindsNothingWithoutReturns) {
  LaserScan scan = AnalyticLaser().halfTurn();
  for (const float empty : {kInf, kNan, -kInf, -1.0F, 0.0F, 80.0F, 81.91F}) {
    SCOPED_TRACE(empty);
    std::fill(scan.ranges_m.begin(), scan.ranges_m.end(), empty);
    EXPECT_TRUE(detect(scan).empty());
  }
}

TEST(TrunkDetector, FindsNothingInsideRoundRoom) {
  LaserScan scan = AnalyticLaser().scan(-kPi, kPi / 360.0, 720);
  std::fill(scan.ranges_m.begin(), scan.ranges_m.end(), 5.0F);
  EXPECT_TRUE(detect(scan).empty());
}

TEST(TrunkDetector, SurvivesTinyScans) {
  for (int beams = 1; beams < 8; ++beams) {
    for (const double spacing : {kPi / 360.0, 2.0 * kPi / beams, 1e-9}) {
      LaserScan scan = AnalyticLaser().scan(0.0, spacing, beams);
      EXPECT_TRUE(detect(scan).empty());
      std::fill(scan.ranges_m.begin(), scan.ranges_m.end(), 3.0F);
      EXPECT_TRUE(detect(scan).empty());
    }
  }
}

TEST(TrunkDetector, SeesTheSameInScanOfOppositeDirection) {
  const AnalyticLaser laser = AnalyticLaser().trunk(7.3, 0.402, 0.5).trunk(14.0, -0.7, 0.8);
  const auto forward = detect(laser.scan(-kPi / 2.0, kPi / 360.0, 361));
  const auto backward = detect(laser.scan(kPi / 2.0, -kPi / 360.0, 361));
  ASSERT_EQ(forward.size(), 2U);
  ASSERT_EQ(backward.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(forward[i].range_m, backward[i].range_m, 1e-5);
    EXPECT_NEAR(forward[i].bearing_rad, backward[i].bearing_rad, 1e-6);
    EXPECT_TRUE(forward[i].covariance.isApprox(backward[i].covariance, 1e-3));
  }
}

TEST(TrunkDetector, FindsTrunkAcrossTheSeamOfFullTurn) {
  const AnalyticLaser laser = AnalyticLaser().trunk(6.0, kPi, 0.6);
  expectTrunk(detect(laser.scan(-kPi, kPi / 360.0, 720)), 6.0, kPi, 0.6);
  // Some drivers repeat the first beam at the end; some count from 0 to a full turn.
  expectTrunk(detect(laser.scan(-kPi, kPi / 360.0, 721)), 6.0, kPi, 0.6);
  expectTrunk(detect(AnalyticLaser().trunk(6.0, 0.0, 0.6).scan(0.0, kPi / 360.0, 720)), 6.0, 0.0,
              0.6);
}

TEST(TrunkDetector, FindsNothingWhenDisabled) {
  PerceptionConfig config;
  config.trunks.enabled = false;
  EXPECT_TRUE(Perception(config).detect(AnalyticLaser().trunk(6.0, 0.0, 0.4).halfTurn()).empty());
}

TEST(Perception, GivesUsableObservationsForAnyScan) {
  PerceptionConfig config;
  config.reflectors.enabled = true;
  config.trunks.min_beams = 1;
  const Perception perception(config);
  RandomGenerator random(3);
  const std::array<float, 6> special = {kInf, -kInf, kNan, -2.0F, 0.0F, 80.0F};
  std::size_t count = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const int beams = 1 + static_cast<int>(sampleUniform(random, 0.0, 60.0));
    const double spacing = sampleUniform(random, -1.0, 1.0) * 2.0 * kPi / beams;
    LaserScan scan = AnalyticLaser().scan(sampleUniform(random, -4.0, 4.0), spacing, beams);
    double range_m = sampleUniform(random, 0.01, 50.0);
    for (float& range : scan.ranges_m) {
      if (sampleUniform(random, 0.0, 1.0) < 0.3) range_m = sampleUniform(random, 0.01, 50.0);
      const auto pick = static_cast<std::size_t>(sampleUniform(random, 0.0, 20.0));
      range = pick < special.size() ? special[pick] : static_cast<float>(range_m);
      scan.intensities.push_back(pick == 19 ? 9000.0F : 0.0F);
    }
    ASSERT_EQ(scanProblem(scan), std::nullopt);
    double last_bearing = -kPi;
    for (const Observation& seen : perception.detect(scan)) {
      ++count;
      EXPECT_GT(seen.range_m, 0.0);
      EXPECT_LE(seen.range_m, 40.5);
      EXPECT_GE(seen.bearing_rad, last_bearing);
      EXPECT_LE(seen.bearing_rad, kPi);
      last_bearing = seen.bearing_rad;
      EXPECT_TRUE(isCovariance(seen.covariance)) << seen.covariance;
      if (seen.type == LandmarkType::kTrunk) {
        EXPECT_GT(seen.diameter_m, 0.0);
        EXPECT_GT(seen.diameter_variance, 0.0);
      }
    }
  }
  EXPECT_GT(count, 1000U);
}

TEST(Perception, RefusesUnusableConfigurationAndListsAllProblems) {
  PerceptionConfig config;
  config.laser.range_noise_m = 0.0;
  config.trunks.min_diameter_m = 2.0;
  try {
    Perception perception(config);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.problems(),
                testing::ElementsAre(testing::HasSubstr("laser.range_noise_m"),
                                     testing::HasSubstr("trunks.min_diameter_m")));
  }
}

}  // namespace
}  // namespace hymm::core
