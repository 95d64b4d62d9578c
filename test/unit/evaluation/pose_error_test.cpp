#include "evaluation/pose_error.h"

#include <limits>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "common/random.h"

namespace hymm::core {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const TimeWindow kAlways{-kInfinity, kInfinity};

Pose2 truePose(double time_s) { return {3.0 * time_s, std::sin(time_s), 0.5 * std::cos(time_s)}; }

Trajectory truth() {
  std::vector<StampedPose> poses;
  for (int i = 0; i < 5000; ++i) poses.push_back({0.1 * i, truePose(0.1 * i)});
  return Trajectory(std::move(poses));
}

TEST(PoseErrors, ShiftedAndTurnedEstimateAlignsToNothing) {
  const Pose2 T{3.0, -4.0, 0.2};
  std::vector<UncertainPose> estimates;
  const Trajectory actual = truth();
  for (const StampedPose& pose : actual.poses()) {
    estimates.push_back({{pose.time_s, T * pose.pose}, Eigen::Matrix3d::Identity()});
  }
  const auto errors = computePoseErrors(estimates, truth(), kAlways);
  ASSERT_TRUE(errors);
  EXPECT_NEAR(errors->aligned_position_m.max, 0.0, 1e-9);
  EXPECT_GT(errors->position_m.rmse, 5.0);
  EXPECT_NEAR(errors->heading_rmse_rad, 0.2, 1e-12);
}

TEST(PoseErrors, ErrorsDrawnFromTheCovarianceAreConsistent) {
  Eigen::Matrix3d P;
  P << 0.09, 0.03, 0.001, 0.03, 0.04, -0.002, 0.001, -0.002, 0.0004;
  const Eigen::Matrix3d L = P.llt().matrixL();
  RandomGenerator generator(11);
  std::vector<UncertainPose> estimates;
  const Trajectory actual = truth();
  for (const StampedPose& pose : actual.poses()) {
    const Eigen::Vector3d unit(sampleNormal(generator, 1.0), sampleNormal(generator, 1.0),
                               sampleNormal(generator, 1.0));
    const Eigen::Vector3d drawn = pose.pose.vector() + L * unit;
    estimates.push_back({{pose.time_s, Pose2::fromVector(drawn)}, P});
  }
  const Consistency nees = computePoseErrors(estimates, truth(), kAlways)->nees;
  // Four standard deviations: sqrt(6 / 5000) of the mean, sqrt(0.95 * 0.05 / 5000) of the share.
  EXPECT_EQ(nees.count, 5000u);
  EXPECT_NEAR(nees.mean, 3.0, 4.0 * 0.0346);
  EXPECT_NEAR(nees.share_in_band, 0.95, 4.0 * 0.0031);
}

TEST(PoseErrors, CertainPosesAreLeftOutOfTheNees) {
  const std::vector<UncertainPose> estimates = {
      {{0.0, truePose(0.0)}, Eigen::Matrix3d::Zero()},
      {{1.0, truePose(1.0)}, Eigen::Matrix3d::Identity()}};
  const auto errors = computePoseErrors(estimates, truth(), kAlways);
  EXPECT_EQ(errors->position_m.count, 2u);
  EXPECT_EQ(errors->nees.count, 1u);
}

TEST(PoseErrors, CountsPosesWithoutTruth) {
  std::vector<UncertainPose> estimates(2);
  estimates[0].pose.time_s = 1.0;
  estimates[1].pose.time_s = 9000.0;
  const auto errors = computePoseErrors(estimates, truth(), kAlways);
  EXPECT_EQ(errors->position_m.count, 1u);
  EXPECT_EQ(errors->without_truth, 1u);
  EXPECT_FALSE(computePoseErrors(estimates, truth(), {5000.0, kInfinity}));
}

TEST(InFrameOf, FirstPoseBecomesTheOrigin) {
  const Trajectory moved = inFrameOf(truePose(0.0), truth());
  EXPECT_NEAR(moved.poses().front().pose.vector().norm(), 0.0, 1e-12);
  const Pose2 expected = inverse(truePose(0.0)) * truePose(7.0);
  EXPECT_NEAR((moved.at(7.0)->vector() - expected.vector()).norm(), 0.0, 1e-9);
}

}  // namespace
}  // namespace hymm::core
