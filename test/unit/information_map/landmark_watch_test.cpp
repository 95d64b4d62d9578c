#include "information_map/landmark_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "random_landmarks.h"

namespace hymm::core {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using testing::IsEmpty;
using testing::SizeIs;

constexpr LandmarkWatch::Tolerance kTolerance{0.02, 0.01, 0.05, 2.0};

LandmarkField fieldOf(const std::vector<Vector2d>& places, double variance = 0.01) {
  const auto n = Eigen::Index(2 * places.size());
  return {mapOf(places, variance * MatrixXd::Identity(n, n)), 15.0};
}

TEST(LandmarkWatch, TellsNewAndGoneLandmarks) {
  LandmarkWatch watch(kTolerance);
  const auto first = watch.compare(fieldOf({{1.0, 2.0}, {3.0, 4.0}}));
  ASSERT_THAT(first, SizeIs(2));
  EXPECT_TRUE(first[0].is_new);
  const auto second = watch.compare(fieldOf({{1.0, 2.0}}));
  ASSERT_THAT(second, SizeIs(1));
  EXPECT_TRUE(second[0].is_gone);
  EXPECT_EQ(second[0].place, Vector2d(3.0, 4.0));
}

TEST(LandmarkWatch, AddsUpSmallMotions) {
  LandmarkWatch watch(kTolerance);
  watch.compare(fieldOf({{0.0, 0.0}}));
  EXPECT_THAT(watch.compare(fieldOf({{0.015, 0.0}})), IsEmpty());
  const auto changes = watch.compare(fieldOf({{0.03, 0.0}}));
  ASSERT_THAT(changes, SizeIs(1));
  EXPECT_NEAR(changes[0].moved_m, 0.03, 1e-12);
  EXPECT_THAT(watch.compare(fieldOf({{0.03, 0.0}})), IsEmpty());
}

TEST(LandmarkWatch, CountsTheGrowthOfRegionsAsMotion) {
  LandmarkWatch watch(kTolerance);
  watch.compare(fieldOf({{0.0, 0.0}}, 0.01));
  const auto changes = watch.compare(fieldOf({{0.0, 0.0}}, 0.04));
  ASSERT_THAT(changes, SizeIs(1));
  EXPECT_GE(changes[0].moved_m, 0.2);  // two sigmas, from 0.1 m to 0.2 m
  EXPECT_LT(changes[0].moved_m, 0.3);
  EXPECT_GT(changes[0].changed, 1.0);
}

TEST(LandmarkWatch, SeesWhereOnlyRelativeCovarianceChanged) {
  const std::vector<Vector2d> places = {{0.0, 0.0}, {5.0, 0.0}};
  LandmarkMap map = mapOf(places, MatrixXd::Identity(4, 4));
  LandmarkWatch watch(kTolerance);
  watch.compare(LandmarkField(map, 15.0));
  map.cross_covariances[0].block = 0.99 * Eigen::Matrix2d::Identity();
  const auto changes = watch.compare(LandmarkField(map, 15.0));
  ASSERT_THAT(changes, SizeIs(2));
  EXPECT_EQ(changes[0].moved_m, 0.0);
  EXPECT_GT(changes[0].changed, 1.0);
}

TEST(LandmarkMotion, MovesPlacesWithTheLandmarksAround) {
  const LandmarkField from = fieldOf({{0.0, 0.0}, {100.0, 0.0}}),
                      to = fieldOf({{1.0, 0.0}, {100.0, -2.0}});
  const LandmarkMotion motion(from, to, 20.0);
  EXPECT_NEAR((motion.move({3.0, 4.0}) - Vector2d(4.0, 4.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((motion.move({95.0, 0.0}) - Vector2d(95.0, -2.0)).norm(), 0.0, 1e-12);
  EXPECT_EQ(motion.move({50.0, 50.0}), Vector2d(50.0, 50.0));
  EXPECT_EQ(motion.largest_m(), 2.0);
}

}  // namespace
}  // namespace hymm::core
