#include "information_map/certain_visibility.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "common/random.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

/// Extremes over 20 000 points of the region's border.
RegionView sampledView(const Vector2d& offset, const Matrix2d& covariance, double sigmas) {
  const Matrix2d root = covariance.llt().matrixL();
  const double bearing = std::atan2(offset.y(), offset.x());
  RegionView view;
  view.nearest_m = 1e9;
  for (int i = 0; i < 20000; ++i) {
    const double angle = 2.0 * kPi * i / 20000.0;
    const Vector2d point = offset + sigmas * root * Vector2d(std::cos(angle), std::sin(angle));
    const double turned = wrapAngle(std::atan2(point.y(), point.x()) - bearing);
    view.nearest_m = std::min(view.nearest_m, point.norm());
    view.farthest_m = std::max(view.farthest_m, point.norm());
    view.left_rad = std::max(view.left_rad, turned);
    view.right_rad = std::max(view.right_rad, -turned);
  }
  return view;
}

RC_GTEST_PROP(RegionView, HoldsTheWholeEllipse, ()) {
  RandomGenerator generator(*rc::gen::arbitrary<std::uint32_t>());
  const Vector2d offset = 10.0 * Vector2d(sampleNormal(generator, 1.0), sampleNormal(generator, 1));
  Matrix2d root;
  for (double& entry : root.reshaped()) entry = sampleNormal(generator, 0.3);
  const Matrix2d covariance = root * root.transpose() + 1e-4 * Matrix2d::Identity();
  const RegionView view = viewRegion(offset, covariance, 2.0);
  const RegionView sampled = sampledView(offset, covariance, 2.0);
  RC_ASSERT(view.farthest_m >= sampled.farthest_m - 1e-9);
  RC_ASSERT(view.nearest_m <= sampled.nearest_m + 1e-9);
  if (view.left_rad < kPi) {
    RC_ASSERT(std::abs(view.left_rad - sampled.left_rad) < 1e-3);
    RC_ASSERT(std::abs(view.right_rad - sampled.right_rad) < 1e-3);
  }
}

TEST(RegionView, OfAnExactLandmarkIsAPoint) {
  const RegionView view = viewRegion({3.0, 4.0}, Matrix2d::Zero(), 2.0);
  EXPECT_DOUBLE_EQ(view.nearest_m, 5.0);
  EXPECT_DOUBLE_EQ(view.farthest_m, 5.0);
  EXPECT_DOUBLE_EQ(view.left_rad, 0.0);
  EXPECT_DOUBLE_EQ(view.right_rad, 0.0);
}

TEST(RegionView, AroundTheSensorFillsAllDirections) {
  const RegionView view = viewRegion({0.1, 0.0}, Matrix2d::Identity(), 2.0);
  EXPECT_EQ(view.left_rad, kPi);
  EXPECT_EQ(view.nearest_m, 0.0);
}

TEST(CertainVisibility, NeedsTheWholeRegionWithinRange) {
  ExpectedSensor sensor;
  sensor.range_m = 15.0;
  const Matrix2d covariance = 0.01 * Matrix2d::Identity();  // region of 0.2 m
  const auto margin_m = [&](double distance_m) {
    return rangeMargin_m(viewRegion({distance_m, 0.0}, covariance, 2.0), sensor);
  };
  EXPECT_NEAR(margin_m(14.79), 15.0 - std::hypot(14.99, 0.2), 1e-9) << "the box's far corner";
  EXPECT_LT(margin_m(14.81), 0.0);
  EXPECT_NEAR(margin_m(1.21), 0.01, 1e-9);
  EXPECT_NEAR(margin_m(1.19), -0.01, 1e-9);
}

}  // namespace
}  // namespace hymm::core
