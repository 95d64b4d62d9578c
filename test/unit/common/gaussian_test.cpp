#include "common/gaussian.h"

#include <cmath>
#include <limits>

#include <Eigen/LU>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace hymm::core {
namespace {

Eigen::Matrix2d matrix(double xx, double xy, double yx, double yy) {
  return (Eigen::Matrix2d() << xx, xy, yx, yy).finished();
}

Eigen::MatrixXd anySquareRoot(Eigen::Index rows, Eigen::Index columns) {
  Eigen::MatrixXd root(rows, columns);
  for (double& value : root.reshaped()) value = *rc::gen::inRange(-1000, 1001) * 1e-2;
  return root;
}

TEST(IsCovariance, AcceptsPositiveDefiniteMatrices) {
  EXPECT_TRUE(isCovariance(Eigen::Matrix2d::Identity()));
  EXPECT_TRUE(isCovariance(matrix(1e-8, 0.0, 0.0, 1e4)));
  EXPECT_TRUE(isCovariance(matrix(2.0, 1.9, 1.9, 2.0)));
}

TEST(IsCovariance, AcceptsTheAsymmetryOfAFloat) {
  EXPECT_TRUE(isCovariance(matrix(1.0, static_cast<double>(0.1F), 0.1, 1.0)));
}

TEST(IsCovariance, RefusesZeroNegativeAndIndefiniteMatrices) {
  EXPECT_FALSE(isCovariance(Eigen::Matrix2d::Zero()));
  EXPECT_FALSE(isCovariance(-Eigen::Matrix2d::Identity()));
  EXPECT_FALSE(isCovariance(matrix(1.0, 0.0, 0.0, -1.0)));
  EXPECT_FALSE(isCovariance(matrix(1.0, 2.0, 2.0, 1.0)));
  EXPECT_FALSE(isCovariance(matrix(1.0, 1.0, 1.0, 1.0)));
}

TEST(IsCovariance, RefusesAsymmetricMatrices) {
  EXPECT_FALSE(isCovariance(matrix(1.0, 0.1, 0.2, 1.0)));
  EXPECT_FALSE(isCovariance(matrix(1.0, 0.1, -0.1, 1.0)));
}

TEST(IsCovariance, RefusesNonFiniteEntries) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(isCovariance(matrix(bad, 0.0, 0.0, 1.0)));
    EXPECT_FALSE(isCovariance(matrix(1.0, bad, bad, 1.0)));
    EXPECT_FALSE(isSemiDefiniteCovariance(matrix(1.0, 0.0, 0.0, bad)));
  }
}

RC_GTEST_PROP(IsSemiDefiniteCovariance, AcceptsEverySquareOfAMatrix, ()) {
  const auto size = *rc::gen::inRange<Eigen::Index>(1, 8);
  const auto rank = *rc::gen::inRange<Eigen::Index>(1, 8);
  const Eigen::MatrixXd root = anySquareRoot(size, rank);
  RC_ASSERT(isSemiDefiniteCovariance(root * root.transpose()));
}

RC_GTEST_PROP(IsSemiDefiniteCovariance, RefusesANegativeDirection, ()) {
  const auto size = *rc::gen::inRange<Eigen::Index>(2, 8);
  const Eigen::MatrixXd root = anySquareRoot(size, size - 1);
  const Eigen::MatrixXd square = root * root.transpose();
  const double scale = std::max(1.0, square.cwiseAbs().maxCoeff());
  // `root` has no component along the removed direction, so that it alone decides.
  const Eigen::VectorXd direction =
      Eigen::MatrixXd(root.transpose()).fullPivLu().kernel().col(0).normalized();
  RC_ASSERT_FALSE(
      isSemiDefiniteCovariance(square - 1e-6 * scale * direction * direction.transpose()));
}

TEST(IsSemiDefiniteCovariance, AcceptsExactKnowledge) {
  EXPECT_TRUE(isSemiDefiniteCovariance(Eigen::Matrix3d::Zero()));
}

TEST(IsSemiDefiniteCovariance, RefusesWhatIsNotSquareOrEmpty) {
  EXPECT_FALSE(isSemiDefiniteCovariance(Eigen::MatrixXd::Identity(2, 3)));
  EXPECT_FALSE(isSemiDefiniteCovariance(Eigen::MatrixXd(0, 0)));
}

}  // namespace
}  // namespace hymm::core
