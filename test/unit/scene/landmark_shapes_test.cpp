#include "scene/landmark_shapes.h"

#include <limits>

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

namespace hymm::core {
namespace {

using testing::HasSubstr;

constexpr double kRounding = 1e-9;

LandmarkEstimate landmarkAt(int id, double x, double y) {
  LandmarkEstimate landmark;
  landmark.id = id;
  landmark.position = {x, y};
  landmark.diameter_m = 1.0;
  return landmark;
}

double draw(double low, double high) {
  return low + (high - low) * *rc::gen::inRange(0, 100001) / 100000.0;
}

RC_GTEST_PROP(EllipseBorder, LiesAtSoManySigmas, ()) {
  Eigen::Matrix2d root;
  root << draw(0.1, 3), draw(-1, 1), draw(-1, 1), draw(0.1, 3);
  const Eigen::Matrix2d covariance = root * root.transpose() + 0.01 * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d position(draw(-1e3, 1e3), draw(-1e3, 1e3));
  const Eigen::Matrix2d information = covariance.inverse();
  for (const Eigen::Vector2d& corner : ellipseBorder(position, covariance, 2.0, 17)) {
    const Eigen::Vector2d apart = corner - position;
    // A subtraction of places up to a kilometre away.
    RC_ASSERT(std::abs(apart.dot(information * apart) - 4.0) < 1e-7);
  }
}

TEST(EllipseBorder, RunsCounterClockwise) {
  const Eigen::Matrix2d covariance = (Eigen::Matrix2d() << 2.0, 0.7, 0.7, 1.0).finished();
  const auto border = ellipseBorder(Eigen::Vector2d(5, 5), covariance, 1.0, 12);
  double doubled_area = 0.0;
  for (std::size_t i = 0; i < border.size(); ++i) {
    const Eigen::Vector2d& a = border[i];
    const Eigen::Vector2d& b = border[(i + 1) % border.size()];
    doubled_area += a.x() * b.y() - b.x() * a.y();
  }
  EXPECT_GT(doubled_area, 0.0);
}

TEST(EllipseBorder, IsAPointWithoutUncertainty) {
  for (const auto& corner : ellipseBorder({3, 4}, Eigen::Matrix2d::Zero(), 2.0, 8)) {
    EXPECT_NEAR((corner - Eigen::Vector2d(3, 4)).norm(), 0.0, kRounding);
  }
}

TEST(LandmarkDiscs, HaveTheDiameterOfTheLandmark) {
  LandmarkStyle style;
  LandmarkEstimate landmark = landmarkAt(1, 10, 0);
  landmark.diameter_m = 4.0;
  const FlatVertices discs = landmarkDiscs({landmark}, style);
  float furthest = 0.0F;
  for (const auto& corner : discs.positions) {
    furthest = std::max(furthest, (corner - Eigen::Vector2f(10, 0)).norm());
  }
  EXPECT_FLOAT_EQ(furthest, 2.0F);
}

TEST(LandmarkDiscs, StayVisibleWhereTheDiameterIsUnknown) {
  LandmarkEstimate landmark = landmarkAt(1, 0, 0);
  landmark.diameter_m = std::numeric_limits<double>::quiet_NaN();
  const FlatVertices discs = landmarkDiscs({landmark}, {});
  float furthest = 0.0F;
  for (const auto& corner : discs.positions) furthest = std::max(furthest, corner.norm());
  EXPECT_FLOAT_EQ(furthest, 0.3F);
}

TEST(LandmarkShapes, AreWholeTrianglesAndLines) {
  const std::vector<LandmarkEstimate> landmarks = {landmarkAt(1, 0, 0), landmarkAt(2, 5, 0)};
  for (const FlatVertices& triangles :
       {landmarkDiscs(landmarks, {}), filledEllipses(landmarks, {})}) {
    EXPECT_EQ(triangles.positions.size() % 3, 0U);
    EXPECT_EQ(triangles.positions.size(), triangles.colours.size());
  }
  const FlatVertices lines = ellipseLines(landmarks, {});
  EXPECT_EQ(lines.positions.size() % 2, 0U);
  EXPECT_EQ(lines.positions.size(), lines.colours.size());
}

TEST(Landmarks, AreRefusedByName) {
  std::vector<LandmarkEstimate> landmarks = {landmarkAt(1, 0, 0), landmarkAt(7, 0, 0)};
  EXPECT_FALSE(problemWith(landmarks));
  landmarks[1].position.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(problemWith(landmarks).value_or(""), HasSubstr("landmark 7 has a position"));
  landmarks[1] = landmarkAt(7, 0, 0);
  landmarks[1].covariance(0, 0) = -1.0;
  EXPECT_THAT(problemWith(landmarks).value_or(""), HasSubstr("landmark 7 has a covariance"));
  landmarks[1] = landmarkAt(1, 0, 0);
  EXPECT_THAT(problemWith(landmarks).value_or(""), HasSubstr("order of ids"));
}

}  // namespace
}  // namespace hymm::core
