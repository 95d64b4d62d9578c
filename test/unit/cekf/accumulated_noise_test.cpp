#include "cekf/accumulated_noise.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "common/random.h"

namespace hymm::core {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kStates = AccumulatedNoise::kStates, kRows = 8;

MatrixXd randomMatrix(RandomGenerator& generator, int rows, int cols) {
  MatrixXd matrix(rows, cols);
  for (double& value : matrix.reshaped()) value = sampleNormal(generator, 1.0);
  return matrix;
}

AccumulatedNoise::Matrix randomCovariance(RandomGenerator& generator, int rank) {
  const MatrixXd root = randomMatrix(generator, kStates, rank);
  return root * root.transpose();
}

class AccumulatedNoiseTest : public testing::Test {
 protected:
  AccumulatedNoiseTest() { noise_.begin(parts_); }

  /// ln of the likelihood of the innovations, with the parts these times as large.
  double logLikelihood(const Eigen::Vector2d& factors) const {
    const MatrixXd D = factors[0] * parts_[0] + factors[1] * parts_[1];
    const MatrixXd S = H_.leftCols(kStates) * D * H_.leftCols(kStates).transpose() + rest_;
    const Eigen::LLT<MatrixXd> llt(S);
    return -0.5 * innovations_.dot(llt.solve(innovations_)) -
           llt.matrixLLT().diagonal().array().log().sum();
  }

  MotionNoiseScale::Evidence evidence() const {
    const MatrixXd D = parts_[0] + parts_[1];
    const MatrixXd S = H_.leftCols(kStates) * D * H_.leftCols(kStates).transpose() + rest_;
    const MatrixXd weighted = S.ldlt().solve(H_);
    return noise_.evidence(weighted.transpose() * innovations_, H_.transpose() * weighted);
  }

  RandomGenerator generator_{3};
  AccumulatedNoise::Parts parts_{randomCovariance(generator_, 2), randomCovariance(generator_, 3)};
  MatrixXd H_ = randomMatrix(generator_, kRows, kStates + 3);  // by what is calibrated, too
  MatrixXd rest_ = MatrixXd::Identity(kRows, kRows);
  VectorXd innovations_ = 2.0 * randomMatrix(generator_, kRows, 1);
  AccumulatedNoise noise_;
};

TEST_F(AccumulatedNoiseTest, HasTheSlopeOfTheLogLikelihood) {
  constexpr double kStep = 1e-5;
  for (int k = 0; k < 2; ++k) {
    Eigen::Vector2d more = Eigen::Vector2d::Ones(), less = more;
    more[k] = std::exp(kStep);
    less[k] = std::exp(-kStep);
    const double numeric = (logLikelihood(more) - logLikelihood(less)) / (2.0 * kStep);
    EXPECT_NEAR(evidence().slope[k], numeric, 1e-7 * std::abs(numeric)) << k;
  }
}

TEST_F(AccumulatedNoiseTest, HasTheVarianceOfTheSlopeAsInformation) {
  const MatrixXd D = parts_[0] + parts_[1];
  const MatrixXd S = H_.leftCols(kStates) * D * H_.leftCols(kStates).transpose() + rest_;
  const MatrixXd root = S.llt().matrixL();
  constexpr int kDraws = 20000;
  Eigen::Matrix2d variance = Eigen::Matrix2d::Zero();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (int i = 0; i < kDraws; ++i) {
    innovations_ = root * randomMatrix(generator_, kRows, 1);
    const Eigen::Vector2d slope = evidence().slope;
    mean += slope / kDraws;
    variance += slope * slope.transpose() / kDraws;
  }
  const Eigen::Matrix2d information = evidence().information;
  EXPECT_LT((variance - information).norm(), 0.05 * information.norm());
  EXPECT_LT(mean.norm(), 0.03);
}

TEST_F(AccumulatedNoiseTest, IsCarriedAlongTheMotion) {
  AccumulatedNoise::Matrix J = AccumulatedNoise::Matrix::Zero();
  J.topRows<3>() = randomMatrix(generator_, 3, kStates);
  J.diagonal().tail<3>() = randomMatrix(generator_, 3, 1);  // what the errors keep
  const AccumulatedNoise::Parts added{randomCovariance(generator_, 1),
                                      randomCovariance(generator_, 1)};
  noise_.carry(J, added);
  const MatrixXd expected = J * (parts_[0] + parts_[1]) * J.transpose() + added[0] + added[1];
  EXPECT_LT((noise_.total(kStates) - expected).norm(), 1e-12 * expected.norm());
}

TEST_F(AccumulatedNoiseTest, IsNothingOfWhatTheMotionDoesNotReach) {
  const VehicleMatrix total = noise_.total(kStates + 3);
  EXPECT_EQ(total.rows(), kStates + 3);
  EXPECT_EQ(total.bottomRows(3).norm() + total.rightCols(3).norm(), 0.0);
}

TEST_F(AccumulatedNoiseTest, SaysNothingWhereNothingWasMeasured) {
  const MotionNoiseScale::Evidence nothing = noise_.evidence({}, {});
  EXPECT_EQ(nothing.slope.norm() + nothing.information.norm(), 0.0);
}

}  // namespace
}  // namespace hymm::core
