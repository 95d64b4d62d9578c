#include "cekf/relative_covariance.h"

#include <vector>

#include <Eigen/QR>
#include <gtest/gtest.h>

#include "common/random.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;

const Vector2d kPosition(3.0, -2.0);
const std::vector<Vector2d> kLandmarks = {{10.0, 1.0}, {-4.0, 6.0}, {2.0, -9.0}};

Vector2d turned(const Vector2d& v) { return {-v.y(), v.x()}; }

/// How a shift and a turn about the origin displace the pose and the landmarks.
MatrixXd rigidMotion(const std::vector<Vector2d>& landmarks) {
  MatrixXd motion = MatrixXd::Zero(static_cast<Eigen::Index>(3 + 2 * landmarks.size()), 3);
  motion.topLeftCorner<3, 3>().setIdentity();
  motion.block<2, 1>(0, 2) = turned(kPosition);
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(3 + 2 * i);
    motion.block<2, 2>(row, 0).setIdentity();
    motion.block<2, 1>(row, 2) = turned(landmarks[i]);
  }
  return motion;
}

MatrixXd randomCovariance(Eigen::Index size, RandomGenerator& generator) {
  MatrixXd root(size, size);
  for (Eigen::Index i = 0; i < root.size(); ++i) {
    root.data()[i] = sampleUniform(generator, -1.0, 1.0);
  }
  return root * root.transpose();
}

TEST(RelativeCovariance, VanishesWhereAllMoveTogether) {
  const MatrixXd motion = rigidMotion(kLandmarks);
  RandomGenerator generator(1);
  const MatrixXd joint = motion * randomCovariance(3, generator) * motion.transpose();
  EXPECT_LT(relativeCovariance(kPosition, kLandmarks, joint).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(RelativeCovariance, IsThePosesOwnWhereTheLandmarksShareAllErrors) {
  const MatrixXd motion = rigidMotion(kLandmarks);
  RandomGenerator generator(2);
  MatrixXd joint = motion * randomCovariance(3, generator) * motion.transpose();
  const Matrix3d own = randomCovariance(3, generator);
  joint.topLeftCorner<3, 3>() += own;
  EXPECT_TRUE(relativeCovariance(kPosition, kLandmarks, joint).isApprox(own, 1e-9));
}

TEST(RelativeCovariance, IsWhatTheBestRigidMotionLeavesOfThePosesError) {
  RandomGenerator generator(3);
  const Eigen::Index size = 9;
  const MatrixXd motion = rigidMotion(kLandmarks);
  // Least squares over the landmarks' errors, for a unit error of each state in turn.
  const MatrixXd fitted = motion.bottomRows<6>().colPivHouseholderQr().solve(
      MatrixXd::Identity(size, size).bottomRows<6>());
  const MatrixXd left = MatrixXd::Identity(size, size).topRows<3>() - motion.topRows<3>() * fitted;
  const MatrixXd joint = randomCovariance(size, generator);
  const Matrix3d expected = left * joint * left.transpose();
  EXPECT_TRUE(relativeCovariance(kPosition, kLandmarks, joint).isApprox(expected, 1e-9));
}

TEST(RelativeCovariance, OfASingleLandmarkTakesItsShiftOnly) {
  RandomGenerator generator(4);
  const MatrixXd joint = randomCovariance(5, generator);
  MatrixXd left = MatrixXd::Identity(3, 5);
  left.block<2, 2>(0, 3) = -Matrix2d::Identity();
  const Matrix3d expected = left * joint * left.transpose();
  EXPECT_TRUE(relativeCovariance(kPosition, {{5.0, 5.0}}, joint).isApprox(expected, 1e-9));
}

TEST(RelativeCovariance, WithoutLandmarksIsThePoses) {
  RandomGenerator generator(5);
  const Matrix3d joint = randomCovariance(3, generator);
  EXPECT_EQ(relativeCovariance(kPosition, {}, joint), joint);
}

/// Vehicle far from certain, six landmarks placed relative to it without noise of their own.
CompressedEkf driftedFilter() {
  CompressedEkf filter(Eigen::Vector3d(0.0, 0.0, 0.0),
                       Eigen::Vector3d(4.0, 4.0, 0.01).asDiagonal());
  for (int i = 0; i < 6; ++i) {
    const Vector2d place(3.0 + i, i % 2 == 0 ? 4.0 : -4.0);
    Eigen::Matrix<double, 2, Eigen::Dynamic> G(2, 3);
    G << 1.0, 0.0, -place.y(), 0.0, 1.0, place.x();
    filter.append(place, G, 1e-6 * Matrix2d::Identity());
  }
  return filter;
}

TEST(RelativeCovariance, OfAFilterLeavesOutTheDriftOfTheWholeNeighbourhood) {
  const CompressedEkf filter = driftedFilter();
  const Matrix3d among = relativeCovariance(filter, {0, 1, 2});
  EXPECT_LT(among(0, 0) + among(1, 1), 1e-4);
  EXPECT_LT(among(2, 2), 1e-6);
  EXPECT_GT(filter.vehicleCovariance()(0, 0), 3.9);
}

TEST(RelativeCovariance, OfAFilterThatSawTooFewTakesTheNearestActive) {
  const CompressedEkf filter = driftedFilter();
  EXPECT_EQ(relativeCovariance(filter, {5}), relativeCovariance(filter, {0, 1, 2, 3, 4, 5}));
}

}  // namespace
}  // namespace hymm::core
