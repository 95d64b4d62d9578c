#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "perception/beam_view.h"
#include "perception/perception.h"
#include "perception/swept_scan.h"
#include "support/analytic_laser.h"

namespace hymm::core {
namespace {

constexpr int kBeams = 720;
constexpr double kTurn_s = 0.1;

/// A turn of 0.1 s from straight behind, counter-clockwise.
LaserScan turnOf(const AnalyticLaser& world) {
  LaserScan scan = world.scan(-kPi, 2.0 * kPi / kBeams, kBeams);
  scan.time_increment_s = kTurn_s / kBeams;
  return scan;
}

std::vector<Observation> detect(const LaserScan& scan) {
  return Perception(PerceptionConfig{}).detect(scan);
}

TEST(RotatingLaser, SeesEachTrunkAtTheTimeOfItsBeams) {
  const auto found =
      detect(turnOf(AnalyticLaser().trunk(8.0, -kPi / 2.0, 0.4).trunk(8.0, kPi / 2.0, 0.4)));
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(found[0].after_stamp_s, 0.25 * kTurn_s, kTurn_s / kBeams);
  EXPECT_NEAR(found[1].after_stamp_s, 0.75 * kTurn_s, kTurn_s / kBeams);
}

TEST(RotatingLaser, SeesEachTrunkAtTheTimesThatItsBeamsTell) {
  LaserScan scan = turnOf(AnalyticLaser().trunk(8.0, kPi / 2.0, 0.4));
  scan.time_increment_s = 0.0;
  scan.beam_times_s.resize(kBeams);
  for (std::size_t i = 0; i < kBeams; ++i) {  // clockwise
    scan.beam_times_s[i] = static_cast<float>(kTurn_s * static_cast<double>(kBeams - i) / kBeams);
  }
  const auto found = detect(scan);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].after_stamp_s, 0.25 * kTurn_s, kTurn_s / kBeams);
  EXPECT_FALSE(BeamView(scan).fullTurn());
  EXPECT_NEAR(BeamView(scan).afterStamp_s(540.5), (179.5 / 720.0) * kTurn_s, 1e-7);
}

TEST(RotatingLaser, SeesReflectorsAtTheTimeOfTheirBeams) {
  LaserScan scan = turnOf(AnalyticLaser().wall(-5.0, 6.0, 5.0, 6.0));
  scan.intensities.assign(kBeams, 0.0F);
  scan.intensities[540] = 30000.0F;  // straight to the left
  PerceptionConfig config;
  config.reflectors.enabled = true;
  const auto found = Perception(config).detect(scan);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].after_stamp_s, 540.0 * kTurn_s / kBeams, 1e-12);
}

TEST(RotatingLaser, LeavesOutATrunkOverTheSeamOfItsTurn) {
  // Its halves are measured a turn apart, from two places.
  LaserScan scan = turnOf(AnalyticLaser().trunk(6.0, kPi, 0.6));
  EXPECT_TRUE(detect(scan).empty());
  scan.time_increment_s = 0.0;
  EXPECT_EQ(detect(scan).size(), 1U);
}

TEST(RotatingLaser, ASweepThatMakesNoSenseIsAnInstant) {
  LaserScan scan = turnOf(AnalyticLaser());
  EXPECT_NEAR(scan.sweep_s(), kTurn_s * (kBeams - 1) / kBeams, 1e-12);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double increment_s : {0.0, nan, -1e-4, 0.01, 1e300, 1e-8}) {
    SCOPED_TRACE(increment_s);
    scan.time_increment_s = increment_s;
    EXPECT_EQ(scan.sweep_s(), 0.0);
    EXPECT_TRUE(BeamView(scan).fullTurn());
    EXPECT_EQ(BeamView(scan).afterStamp_s(100.0), 0.0);
  }
  EXPECT_EQ(LaserScan().sweep_s(), 0.0);
}

TEST(SweptScan, KnowsWhereTheSensorWasAtEachBeam) {
  SweepMotion motion;
  motion.pieces = {{0.0, 5.0, 0.0, 0.0}};
  const LaserScan scan = sweptScan(turnOf(AnalyticLaser()), motion, {3.0, 0.0, kPi / 2.0});
  ASSERT_EQ(scan.T_stamp_beam.size(), std::size_t{kBeams});
  EXPECT_EQ(scan.T_stamp_beam[0].y_m, 0.0);
  EXPECT_NEAR(scan.T_stamp_beam[360].y_m, -0.25, 1e-12);  // ahead is to the right of the sensor
  const Pose2 T_map_beam = scan.poseAtBeam(360, {10.0, 20.0, kPi / 2.0});
  EXPECT_NEAR(T_map_beam.x_m, 10.25, 1e-12);
  EXPECT_NEAR(T_map_beam.y_m, 20.0, 1e-12);
}

TEST(SweptScan, TakesTheTimesOfBeamsWhereTheyAreTold) {
  SweepMotion motion;
  motion.pieces = {{0.0, 5.0, 0.0, 0.0}};
  LaserScan scan = turnOf(AnalyticLaser());
  scan.time_increment_s = 0.0;
  scan.beam_times_s.resize(kBeams);
  for (std::size_t i = 0; i < kBeams; ++i) {  // clockwise
    scan.beam_times_s[i] = static_cast<float>(kTurn_s * static_cast<double>(kBeams - i) / kBeams);
  }
  scan = sweptScan(std::move(scan), motion, {});
  ASSERT_EQ(scan.T_stamp_beam.size(), std::size_t{kBeams});
  EXPECT_NEAR(scan.T_stamp_beam[0].x_m, 5.0 * kTurn_s, 1e-6);
  EXPECT_NEAR(scan.T_stamp_beam[540].x_m, 0.25 * 5.0 * kTurn_s, 1e-6);
}

TEST(SweptScan, StaysAsItIsWhereNothingMovedOrNoTimeIsTold) {
  SweepMotion motion;
  motion.pieces = {{0.0, 5.0, 0.0, 0.0}};
  LaserScan scan = turnOf(AnalyticLaser());
  EXPECT_TRUE(sweptScan(scan, SweepMotion(), {}).T_stamp_beam.empty());
  scan.time_increment_s = 0.0;
  EXPECT_TRUE(sweptScan(scan, motion, {}).T_stamp_beam.empty());
  const Pose2 T_map_laser{1.0, 2.0, 0.3};
  EXPECT_EQ(scan.poseAtBeam(5, T_map_laser).vector(), T_map_laser.vector());
}

}  // namespace
}  // namespace hymm::core
