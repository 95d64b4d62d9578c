#include "perception/scan_check.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>

#include "common/angles.h"

namespace hymm::core {
namespace {

using testing::HasSubstr;
using testing::Optional;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr float kInfF = std::numeric_limits<float>::infinity();
constexpr float kNanF = std::numeric_limits<float>::quiet_NaN();

LaserScan goodScan() {
  LaserScan scan;
  scan.time_s = 12.5;
  scan.angle_min_rad = -kPi / 2.0;
  scan.angle_increment_rad = kPi / 360.0;
  scan.range_max_m = 80.0;
  scan.ranges_m.assign(361, 5.0F);
  return scan;
}

TEST(ScanProblem, IsNothingForAUsableScan) {
  EXPECT_EQ(scanProblem(goodScan()), std::nullopt);
  LaserScan reversed = goodScan();
  reversed.angle_increment_rad = -reversed.angle_increment_rad;
  EXPECT_EQ(scanProblem(reversed), std::nullopt);
}

TEST(ScanProblem, AllowsAnythingInSingleRanges) {
  LaserScan scan = goodScan();
  scan.ranges_m = {kInfF, -kInfF, kNanF, -1.0F};
  EXPECT_EQ(scanProblem(scan), std::nullopt);
}

TEST(ScanProblem, NamesStampThatIsNotFinite) {
  LaserScan scan = goodScan();
  scan.time_s = kNan;
  EXPECT_THAT(scanProblem(scan), Optional(HasSubstr("stamp is nan")));
}

TEST(ScanProblem, NamesBadAngles) {
  LaserScan scan = goodScan();
  scan.angle_min_rad = kNan;
  EXPECT_THAT(scanProblem(scan), Optional(HasSubstr("angle_min is nan")));
  scan = goodScan();
  scan.angle_increment_rad = 0.0;
  EXPECT_THAT(scanProblem(scan), Optional(HasSubstr("angle_increment is 0")));
}

TEST(ScanProblem, RefusesMoreThanOneTurnButNotARepeatedBeam) {
  LaserScan scan = goodScan();
  scan.ranges_m.assign(721, 5.0F);
  EXPECT_EQ(scanProblem(scan), std::nullopt);
  scan.ranges_m.assign(722, 5.0F);
  EXPECT_THAT(scanProblem(scan), Optional(HasSubstr("more than one turn")));
}

TEST(ScanProblem, NamesRangeLimitsOutOfOrder) {
  LaserScan scan = goodScan();
  scan.range_min_m = 90.0;
  EXPECT_THAT(scanProblem(scan), Optional(HasSubstr("range_min is 90 m and range_max 80 m")));
  scan = goodScan();
  scan.range_min_m = -0.1;
  EXPECT_THAT(scanProblem(scan), Optional(HasSubstr("range_min is -0.1 m")));
  scan = goodScan();
  scan.range_max_m = kNan;
  EXPECT_THAT(scanProblem(scan), Optional(HasSubstr("range_max nan m")));
}

TEST(ScanProblem, NamesWrongLengths) {
  LaserScan scan = goodScan();
  scan.intensities.assign(360, 0.0F);
  EXPECT_THAT(scanProblem(scan), Optional(HasSubstr("intensities has 360 values and ranges 361")));
  scan.intensities.clear();
  scan.ranges_m.clear();
  EXPECT_THAT(scanProblem(scan), Optional(HasSubstr("ranges is empty")));
}

TEST(ScanProblem, NamesTimesOfBeamsThatMakeNoSense) {
  LaserScan scan = goodScan();
  scan.beam_times_s.assign(361, 0.05F);
  EXPECT_EQ(scanProblem(scan), std::nullopt);
  for (const float wrong_s : {kNanF, -0.01F, 1.1F}) {
    scan.beam_times_s[7] = wrong_s;
    EXPECT_THAT(scanProblem(scan), Optional(HasSubstr("s after the stamp; it must be 0 to 1 s")));
  }
  scan.beam_times_s.assign(360, 0.05F);
  EXPECT_THAT(scanProblem(scan), Optional(HasSubstr("times are known for 360 of 361 beams")));
}

TEST(InvalidRanges, CountsNegativeRangesOnly) {
  LaserScan scan = goodScan();
  scan.ranges_m = {kInfF, -kInfF, kNanF, -1.0F, 0.0F, 3.0F, -0.001F};
  EXPECT_EQ(invalidRanges(scan), 2U);
}

TEST(SweepProblem, IsNothingForRotatingLasersAndOnesThatTellNothing) {
  LaserScan scan = goodScan();
  EXPECT_EQ(sweepProblem(scan, 0.0), std::nullopt);
  scan.time_increment_s = 0.1 / 720.0;
  EXPECT_EQ(sweepProblem(scan, 0.0), std::nullopt);
  EXPECT_EQ(sweepProblem(scan, 0.1), std::nullopt);
}

TEST(SweepProblem, NamesATimeIncrementThatMakesNoSense) {
  LaserScan scan = goodScan();
  scan.time_increment_s = kNan;
  EXPECT_THAT(sweepProblem(scan, 0.0), Optional(HasSubstr("time_increment is nan")));
  scan.time_increment_s = -1e-4;
  EXPECT_THAT(sweepProblem(scan, 0.0), Optional(HasSubstr("time_increment is -0.0001")));
  scan.time_increment_s = 0.1;
  EXPECT_THAT(sweepProblem(scan, 0.0), Optional(HasSubstr("take 36.1 s")));
}

TEST(SweepProblem, NamesAScanThatTakesLongerThanTheTimeToTheNext) {
  LaserScan scan = goodScan();
  scan.time_increment_s = 0.2 / 361.0;
  EXPECT_THAT(sweepProblem(scan, 0.1), Optional(HasSubstr("scan_time says 0.1 s")));
}

}  // namespace
}  // namespace hymm::core
