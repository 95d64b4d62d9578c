#include "pipeline/grid_mapper.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/landmark_triangle.h"
#include "support/shipped_config.h"

namespace hymm::core {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

/// Three landmarks around the origin that span an LTR of 14 m.
std::shared_ptr<LandmarkMap> triangle(std::uint64_t version) {
  return std::make_shared<LandmarkMap>(
      test::landmarkTriangle({{{-5.0, -5.0}, {10.0, -5.0}, {-5.0, 10.0}}}, version));
}

/// A scan with one beam of 2 m straight ahead, from base_link at the origin.
MappedScan stepOf(std::uint64_t version) {
  MappedScan step;
  step.pose.map_version = version;
  step.pose.time_s = 0.1 * static_cast<double>(version);
  step.update.since_version = version - 1;
  step.update.version = version;
  LaserScan scan;
  scan.time_s = step.pose.time_s;
  scan.angle_increment_rad = 0.01;
  scan.range_max_m = 80.0;
  scan.ranges_m = {2.0F};
  step.scan = scan;
  return step;
}

MappedScan stepWithMap(std::uint64_t version) {
  MappedScan step = stepOf(version);
  step.map = triangle(version);
  return step;
}

bool isOccupied(const GridMapper& mapper, const Eigen::Vector2d& place) {
  const LayerQuery answer = mapper.map().query("occupancy", place);
  return answer.value && answer.value->value > 0.5;
}

TEST(GridMapper, WritesEachScanAmongTheLandmarksOfItsVersion) {
  GridMapper mapper{HymmGridConfig()};
  const MappedOutcome first = mapper.process(stepWithMap(5));
  EXPECT_TRUE(first.follows);
  EXPECT_TRUE(first.written);
  EXPECT_TRUE(first.topology);
  EXPECT_THAT(mapper.topology(), SizeIs(1));
  EXPECT_TRUE(isOccupied(mapper, {2.0, 0.01}));

  MappedScan moved = stepOf(6);  // the whole neighbourhood was 1 m off
  const auto landmarks = triangle(6);
  for (LandmarkEstimate landmark : landmarks->landmarks) {
    landmark.position.x() += 1.0;
    moved.update.changed.push_back(landmark);
  }
  moved.scan.reset();
  EXPECT_TRUE(mapper.process(moved).follows);
  EXPECT_TRUE(isOccupied(mapper, {3.0, 0.01}));
  EXPECT_FALSE(isOccupied(mapper, {2.0, 0.01}));
}

TEST(GridMapper, WaitsForAWholeMapWhereChangesAreMissing) {
  GridMapper mapper{HymmGridConfig()};
  mapper.process(stepWithMap(5));
  const MappedOutcome missed = mapper.process(stepOf(8));  // since 7
  EXPECT_FALSE(missed.follows);
  EXPECT_FALSE(missed.written);
  EXPECT_THAT(missed.reason, HasSubstr("whole map"));
  EXPECT_EQ(mapper.counts().without_landmarks, 1u);
  EXPECT_TRUE(mapper.process(stepWithMap(9)).written);
  EXPECT_TRUE(mapper.process(stepOf(10)).written);
}

TEST(GridMapper, DoesNotWriteWhereThePoseIsNotCertainAmongTheLandmarks) {
  GridMapper mapper{HymmGridConfig()};
  MappedScan step = stepWithMap(1);
  step.pose.covariance = 100.0 * Eigen::Matrix3d::Identity();  // in map: does no harm
  EXPECT_TRUE(mapper.process(step).written);
  step = stepOf(2);
  step.pose.relative_covariance(0, 0) = 0.25;
  const MappedOutcome outcome = mapper.process(step);
  EXPECT_TRUE(outcome.follows);
  EXPECT_FALSE(outcome.written);
  EXPECT_THAT(outcome.reason, HasSubstr("not certain enough"));
  EXPECT_EQ(mapper.counts().not_written, 1u);
}

TEST(GridMapper, BeginsAnewWithTheFilter) {
  GridMapper mapper{HymmGridConfig()};
  mapper.process(stepWithMap(5));
  mapper.reset();
  EXPECT_THAT(mapper.topology(), SizeIs(0));
  EXPECT_TRUE(mapper.process(stepWithMap(2)).written);
}

TEST(PosedScan, StandsWhereTheSensorDoes) {
  PoseEstimate pose;
  pose.T_map_base = {10.0, 5.0, kPi / 2.0};
  pose.T_base_sensor = {3.0, 0.0, 0.0};
  const PosedScan posed = posedScan(LaserScan(), pose, 0.0);
  EXPECT_NEAR(posed.T_map_laser.x_m, 10.0, 1e-12);
  EXPECT_NEAR(posed.T_map_laser.y_m, 8.0, 1e-12);
}

TEST(PosedScan, LosesTheSystematicErrorOfItsRanges) {
  PoseEstimate pose;
  pose.range_offset_m = 0.25;
  LaserScan scan;
  scan.ranges_m = {2.0F, std::numeric_limits<float>::infinity()};
  EXPECT_THAT(posedScan(scan, pose, 0.0).scan.ranges_m,
              testing::ElementsAre(1.75F, std::numeric_limits<float>::infinity()));
}

TEST(PosedScan, LeavesOutBeamsThatHitTheVehicleItself) {
  LaserScan scan;
  scan.ranges_m = {0.8F, 2.0F};
  const PosedScan posed = posedScan(scan, PoseEstimate(), 1.0);
  EXPECT_TRUE(std::isnan(posed.scan.ranges_m[0]));
  EXPECT_EQ(posed.scan.ranges_m[1], 2.0F);
}

TEST(PosedScan, HeadingErrorShiftsASensorInFrontOfTheVehicle) {
  PoseEstimate pose;
  pose.T_map_base = {10.0, 5.0, 0.4};
  pose.relative_covariance = Eigen::Vector3d(0.0016, 0.0016, 0.0001).asDiagonal();
  pose.T_base_sensor = {3.0, 0.0, 0.0};
  const PosedScan posed = posedScan(LaserScan(), pose, 0.0);
  EXPECT_NEAR(posed.pose_deviation_m, std::sqrt(0.0016 + 9.0 * 0.0001), 1e-12);
  EXPECT_NEAR(posed.heading_deviation_rad, 0.01, 1e-12);
}

TEST(PosedScan, KnowsHowItsSensorMovedWhileItWasMeasured) {
  LaserScan scan;
  scan.time_increment_s = 0.01;
  scan.ranges_m.assign(11, 5.0F);
  PoseEstimate pose;
  pose.T_map_base = {10.0, 5.0, kPi / 2.0};
  EXPECT_TRUE(posedScan(scan, pose, 0.0).scan.T_stamp_beam.empty());
  pose.sweep.pieces = {{0.0, 4.0, 0.0, 0.0}};
  const PosedScan posed = posedScan(scan, pose, 0.0);
  ASSERT_EQ(posed.scan.T_stamp_beam.size(), 11U);
  EXPECT_NEAR(posed.scan.poseAtBeam(10, posed.T_map_laser).y_m, 5.4, 1e-12);
}

TEST(HymmGridConfig, IsDocumentedByItsShippedFile) {
  test::expectDocumentedByShippedFile("hymm_grid", HymmGridConfig());
}

}  // namespace
}  // namespace hymm::core
