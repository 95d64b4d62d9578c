#include "hybrid_map/ltr_geometry.h"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "common/random.h"

namespace hymm::core {
namespace {

const Corners kRight = {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(4.0, 0.0),
                        Eigen::Vector2d(0.0, 3.0)};

Corners shifted(const Corners& corners, double x, double y) {
  const Eigen::Vector2d shift(x, y);
  return {corners[0] + shift, corners[1] + shift, corners[2] + shift};
}

TEST(Overlap, NeighboursThatShareASideDoNotOverlap) {
  const Corners other = {kRight[1], Eigen::Vector2d(4.0, 3.0), kRight[2]};
  EXPECT_FALSE(overlap(kRight, other));
  EXPECT_FALSE(overlap(other, kRight));
}

TEST(Overlap, TrianglesThatShareAVertexMayOrMayNot) {
  const Corners beside = {kRight[0], Eigen::Vector2d(-1.0, 3.0), Eigen::Vector2d(-3.0, 0.0)};
  const Corners onto = {kRight[0], Eigen::Vector2d(4.0, 1.0), Eigen::Vector2d(1.0, 4.0)};
  EXPECT_FALSE(overlap(kRight, beside));
  EXPECT_TRUE(overlap(kRight, onto));
}

TEST(Overlap, FindsCrossingWithoutAnyCornerInside) {
  const Corners spike = {Eigen::Vector2d(-1.0, 0.9), Eigen::Vector2d(9.0, 1.0),
                         Eigen::Vector2d(-1.0, 1.1)};
  EXPECT_TRUE(overlap(kRight, spike));
}

TEST(Overlap, FindsTriangleInsideAnother) {
  const Corners inside = {Eigen::Vector2d(0.5, 0.5), Eigen::Vector2d(1.0, 0.5),
                          Eigen::Vector2d(0.5, 1.0)};
  EXPECT_TRUE(overlap(kRight, inside));
  EXPECT_TRUE(overlap(inside, kRight));
}

TEST(Overlap, TouchingSidesDoNotOverlapButAHairMoreDoes) {
  const Corners below = {Eigen::Vector2d(1.0, -2.0), Eigen::Vector2d(3.0, -2.0),
                         Eigen::Vector2d(2.0, 0.0)};
  EXPECT_FALSE(overlap(kRight, below));
  EXPECT_TRUE(overlap(kRight, shifted(below, 0.0, 1e-9)));
}

/// Whether any of many points of `a` is inside `b`: needs no separating line.
bool sharesAPoint(const Corners& a, const Corners& b) {
  constexpr int kSteps = 60;
  for (int i = 1; i < kSteps; ++i) {
    for (int j = 1; i + j < kSteps; ++j) {
      const double u = double(i) / kSteps, v = double(j) / kSteps;
      const Eigen::Vector2d p = a[0] + u * (a[1] - a[0]) + v * (a[2] - a[0]);
      if (turn(b[0], b[1], p) > 0 && turn(b[1], b[2], p) > 0 && turn(b[2], b[0], p) > 0) {
        return true;
      }
    }
  }
  return false;
}

RC_GTEST_PROP(Overlap, IsTrueWhereverTrianglesShareAPoint, ()) {
  RandomGenerator generator(*rc::gen::inRange<std::uint64_t>(0, 1ULL << 40U));
  const auto triangle = [&] {
    Corners corners;
    for (auto& corner : corners) {
      corner = {sampleUniform(generator, 0.0, 10.0), sampleUniform(generator, 0.0, 10.0)};
    }
    if (turn(corners[0], corners[1], corners[2]) < 0) std::swap(corners[1], corners[2]);
    return corners;
  };
  const Corners a = triangle(), b = triangle();
  RC_ASSERT(overlap(a, b) == overlap(b, a));
  RC_ASSERT(overlap(a, b) || !sharesAPoint(a, b));
}

TEST(SmallestAngle, OfKnownTriangles) {
  EXPECT_NEAR(smallestAngle(kRight), std::atan2(3.0, 4.0), 1e-15);
  EXPECT_EQ(smallestAngle({kRight[0], kRight[1], Eigen::Vector2d(2.0, 0.0)}), 0.0);
}

TEST(SmallestHeight, StandsOnTheLongestSide) {
  EXPECT_NEAR(smallestHeight(kRight), 3.0 * 4.0 / 5.0, 1e-15);
  EXPECT_EQ(smallestHeight({kRight[0], kRight[0], kRight[0]}), 0.0);
}

TEST(KeepsShape, AcceptsTurnsAndRefusesReflections) {
  EXPECT_TRUE(keepsShape(Eigen::Rotation2Dd(2.0).toRotationMatrix(), 1.01));
  EXPECT_FALSE(keepsShape(Eigen::Vector2d(1.0, -1.0).asDiagonal(), 2.0));
  EXPECT_FALSE(keepsShape(Eigen::Matrix2d::Zero(), 2.0));
}

RC_GTEST_PROP(KeepsShape, ComparesThePrincipalStretches, ()) {
  RandomGenerator generator(*rc::gen::inRange<std::uint64_t>(0, 1ULL << 40U));
  const Eigen::Vector2d stretches(sampleUniform(generator, 0.4, 2.0),
                                  sampleUniform(generator, 0.4, 2.0));
  const auto turnBy = [&] {
    return Eigen::Rotation2Dd(sampleUniform(generator, -3.0, 3.0)).toRotationMatrix();
  };
  const Eigen::Matrix2d deformation = turnBy() * stretches.asDiagonal() * turnBy();
  const double limit = 1.5;
  const bool expected = stretches.maxCoeff() <= limit && stretches.minCoeff() >= 1.0 / limit;
  RC_ASSERT(keepsShape(deformation, limit) == expected);
}

TEST(BestRigidFit, FindsTheTurnAndShiftOfARigidMove) {
  const Pose2 moved{3.0, -2.0, 2.5};
  const Corners to = {moved * kRight[0], moved * kRight[1], moved * kRight[2]};
  const Pose2 fit = bestRigidFit(kRight, to, {1.0, 1.0, 1.0});
  EXPECT_LT((fit.vector() - moved.vector()).norm(), 1e-14);
}

TEST(BestRigidFit, LooksOnlyAtCornersThatAreStillThere) {
  const Corners to = {kRight[0] + Eigen::Vector2d(1.0, 0.0), Eigen::Vector2d(1.0, 4.0),
                      Eigen::Vector2d(77.0, 77.0)};
  const Pose2 two = bestRigidFit(kRight, to, {1.0, 1.0, 0.0});
  EXPECT_LT((two.vector() - Eigen::Vector3d(1.0, 0.0, M_PI_2)).norm(), 1e-14);
  const Pose2 one = bestRigidFit(kRight, to, {1.0, 0.0, 0.0});
  EXPECT_LT((one.vector() - Eigen::Vector3d(1.0, 0.0, 0.0)).norm(), 1e-14);
  EXPECT_EQ(bestRigidFit(kRight, to, {0.0, 0.0, 0.0}).vector().norm(), 0.0);
}

Eigen::Matrix<double, 6, 6> randomCovariance(RandomGenerator& generator) {
  Eigen::Matrix<double, 6, 6> root;
  for (int i = 0; i < 36; ++i) root(i) = sampleNormal(generator, 0.05);
  return root * root.transpose();
}

TEST(ShapeFactor, DoesNotSeeWhatAllCornersHaveInCommon) {
  Eigen::Matrix<double, 6, 1> turn_about_origin;
  for (int i = 0; i < 3; ++i) {
    turn_about_origin.segment<2>(2 * i) << -kRight[std::size_t(i)].y(), kRight[std::size_t(i)].x();
  }
  Eigen::Matrix<double, 6, 2> shift;
  shift << Eigen::Matrix2d::Identity(), Eigen::Matrix2d::Identity(), Eigen::Matrix2d::Identity();
  const Eigen::Matrix<double, 6, 6> common =
      4.0 * shift * shift.transpose() + 0.1 * turn_about_origin * turn_about_origin.transpose();
  EXPECT_NEAR(shapeFactor(kRight, common), 1.0, 1e-6);
}

// Independent of the closed form: the length of a segment inside the triangle, differentiated
// numerically by the corners.
RC_GTEST_PROP(ShapeFactor, BoundsTheDeviationOfEveryLength, ()) {
  RandomGenerator generator(*rc::gen::inRange<std::uint64_t>(0, 1ULL << 40U));
  const Eigen::Matrix<double, 6, 6> covariance = randomCovariance(generator);
  const double K = shapeFactor(kRight, covariance);
  double worst = 0.0;
  for (int step = 0; step < 180; ++step) {
    const Eigen::Vector2d u(std::cos(M_PI * step / 180), std::sin(M_PI * step / 180));
    Eigen::Matrix2d M;
    M << kRight[1] - kRight[0], kRight[2] - kRight[0];
    const Eigen::Vector2d local = M.inverse() * u;
    Eigen::Matrix<double, 6, 1> gradient;
    const double h = 1e-6;
    for (int k = 0; k < 6; ++k) {
      Corners c = kRight;
      c[std::size_t(k / 2)][k % 2] += h;
      const double longer = (local.x() * (c[1] - c[0]) + local.y() * (c[2] - c[0])).norm();
      gradient[k] = (longer - 1.0) / h;
    }
    worst = std::max(worst, 3.0 * std::sqrt(gradient.dot(covariance * gradient)));
  }
  RC_ASSERT(K - 1.0 >= worst - 1e-5);
  RC_ASSERT(K - 1.0 <= 1.02 * worst + 1e-5);
}

}  // namespace
}  // namespace hymm::core
