#include "hybrid_map/scan_matcher.h"

#include <cmath>

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "common/random.h"
#include "true_drive.h"

namespace hymm::core {
namespace {

using testing::HasSubstr;

Pose2 offBy(RandomGenerator& generator, double metres, double radians) {
  return {sampleUniform(generator, -metres, metres), sampleUniform(generator, -metres, metres),
          sampleUniform(generator, -radians, radians)};
}

/// 40 s around the car park, and the scans of the last 10 s with their true poses.
class CarPark : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    drive_ = new TrueDrive(worldOf("car_park", 1, 40.0), HybridMapConfig{}, 1);
    drive_->drive([](const PosedScan& posed) {
      if (posed.scan.time_s > 30.0) scans_->push_back(posed);
    });
  }
  static void TearDownTestSuite() {
    delete drive_;
    drive_ = nullptr;
    scans_->clear();
  }
  static const HybridMap& map() { return drive_->map(); }
  static const std::vector<PosedScan>& scans() { return *scans_; }

 private:
  static TrueDrive* drive_;
  static std::vector<PosedScan>* scans_;
};
TrueDrive* CarPark::drive_ = nullptr;
std::vector<PosedScan>* CarPark::scans_ = new std::vector<PosedScan>;

TEST_F(CarPark, AScanIsFoundWhereItWasTaken) {
  RandomGenerator generator(1);
  const ScanMatcher matcher({});
  int count = 0;
  double squares_m2 = 0.0, nees = 0.0;
  for (std::size_t i = 0; i < scans().size(); i += 3) {
    const PosedScan& posed = scans()[i];
    const Pose2 guess = posed.T_map_laser * offBy(generator, 0.6, 0.08);
    const ScanMatch match = matcher.match(map(), posed.scan, guess);
    ASSERT_TRUE(match.matched) << match.reason;
    EXPECT_GT(match.score, 0.7);
    const Eigen::Vector3d error =
        Pose2::fromVector(match.T_map_laser.vector() - posed.T_map_laser.vector()).vector();
    EXPECT_LT(error.head<2>().norm(), 0.1);  // half a cell
    EXPECT_LT(std::abs(error.z()), 0.015);
    ++count;
    squares_m2 += error.head<2>().squaredNorm();
    nees += error.dot(match.covariance.inverse() * error);
  }
  EXPECT_LT(std::sqrt(squares_m2 / count), 0.05);
  // At least as certain as it claims: the 99.9 % quantile of chi-square for 18 poses is 92.
  ASSERT_EQ(count, 18);
  EXPECT_LT(nees, 92.0);
  EXPECT_GT(nees, 5.0);  // and not far less
}

TEST_F(CarPark, AgreesWithAScanWhereItWasTakenAndNotBesideIt) {
  const ScanMatcher matcher({});
  for (std::size_t i = 0; i < scans().size(); i += 5) {
    const PosedScan& posed = scans()[i];
    const Pose2 beside = posed.T_map_laser * Pose2{1.0, 1.0, 0.1};
    EXPECT_GT(matcher.agreement(map(), posed.scan, posed.T_map_laser).correlation, 0.8);
    EXPECT_LT(matcher.agreement(map(), posed.scan, beside).correlation, 0.6);
  }
}

TEST_F(CarPark, WhatIsUnexploredHasNoSayInTheAgreement) {
  // As long as the car sees new ground, all that was seen before agrees.
  TrueDrive drive(worldOf("car_park", 1, 12.0), HybridMapConfig{}, 1);
  const ScanMatcher matcher({});
  int unexplored = 0;
  drive.drive([&](const PosedScan& posed) {
    const ScanAgreement agreement = matcher.agreement(drive.map(), posed.scan, posed.T_map_laser);
    if (posed.scan.time_s < 3.0) return;
    EXPECT_GT(agreement.correlation, 0.7) << posed.scan.time_s;
    if (agreement.known_share < 0.9) ++unexplored;
  });
  EXPECT_GT(unexplored, 5);
}

TEST_F(CarPark, ACorridorTellsNothingAlongItself) {
  // Two walls along x, 4.1 m to each side, seen from many places along the middle.
  HybridMap map(HybridMapConfig{});
  ASSERT_TRUE(map.apply(mapOf({{-10, -10}, {10, -10}, {10, 10}, {-10.5, 10}})).accepted);
  PosedScan posed;
  posed.map_version = 1;
  posed.scan.angle_min_rad = -kPi;
  posed.scan.angle_increment_rad = kPi / 180.0;
  posed.scan.range_max_m = 80.0;
  for (int i = 0; i < 360; ++i) {
    const double side = std::abs(std::sin(posed.scan.bearing(std::size_t(i))));
    posed.scan.ranges_m.push_back(static_cast<float>(side > 0.7 ? 4.1 / side : NAN));
  }
  for (double x = -5.0; x <= 5.0; x += 0.1) {
    posed.T_map_laser.x_m = x;
    ASSERT_TRUE(map.insert(posed).accepted);
  }
  const ScanMatch match = ScanMatcher({}).match(map, posed.scan, {0.0, 0.3, 0.02});
  ASSERT_TRUE(match.matched) << match.reason;
  EXPECT_NEAR(match.T_map_laser.x_m, 0.0, 1.2);  // the window, and a step of the lattice
  EXPECT_NEAR(match.T_map_laser.y_m, 0.0, 0.1);
  EXPECT_NEAR(match.T_map_laser.yaw_rad, 0.0, 0.017);  // half a cell at the far ends
  EXPECT_LT(match.covariance(1, 1), 0.01);
  EXPECT_GT(match.covariance(0, 0), 10.0 * match.covariance(1, 1));
}

TEST_F(CarPark, SaysWhyItMatchesNothing) {
  const ScanMatcher matcher({});
  const PosedScan& posed = scans().front();
  const HybridMap empty(HybridMapConfig{});
  EXPECT_THAT(matcher.match(empty, posed.scan, posed.T_map_laser).reason,
              HasSubstr("knows no obstacles"));
  EXPECT_THAT(matcher.match(map(), posed.scan, {NAN, 0.0, 0.0}).reason, HasSubstr("not finite"));
  EXPECT_THAT(matcher.match(map(), {}, posed.T_map_laser).reason, testing::Not(testing::IsEmpty()));
  EXPECT_FALSE(matcher.match(map(), {}, posed.T_map_laser).matched);
  LaserScan nothing_hit = posed.scan;
  for (float& range : nothing_hit.ranges_m) range = INFINITY;
  EXPECT_THAT(matcher.match(map(), nothing_hit, posed.T_map_laser).reason,
              HasSubstr("no beam of the scan ends"));
  LaserScan few = nothing_hit;
  std::copy_n(posed.scan.ranges_m.begin(), 5, few.ranges_m.begin());
  EXPECT_THAT(matcher.match(map(), few, posed.T_map_laser).reason, HasSubstr("are needed"));
  EXPECT_FALSE(matcher.match(map(), posed.scan, posed.T_map_laser * Pose2{9.0, 5.0, 0.8}).matched);
}

TEST_F(CarPark, HasNoOpinionWhereTheMapKnowsTooLittle) {
  const HybridMap empty(HybridMapConfig{});
  const ScanAgreement agreement =
      ScanMatcher({}).agreement(empty, scans().front().scan, scans().front().T_map_laser);
  EXPECT_TRUE(std::isnan(agreement.correlation));
  EXPECT_EQ(agreement.known_beams, 0);
  EXPECT_EQ(agreement.known_share, 0.0);
}

TEST(ScanMatcher, RefusesAWindowThatIsNotPositive) {
  ScanMatcherConfig config;
  config.search_radius_m = 0.0;
  config.min_score = 2.0;
  try {
    const ScanMatcher matcher(config);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.problems().size(), 2U);
  }
}

}  // namespace
}  // namespace hymm::core
