#include "cekf/pairing_evidence.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/angles.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr double kDensity = 0.01;  // one object in 100 m^2
const double kOneInAHundred = std::log(100.0);

Pairing pairing(int number, const Vector2d& innovation) {
  return {number, number, innovation, 0.0, kDensity};
}

/// Pairings that share an error of the vehicle, beside `own_m` of each: covariance of innovations.
MatrixXd sharedError(int pairings, double shared_m, double own_m) {
  MatrixXd S(2 * pairings, 2 * pairings);
  for (int i = 0; i < pairings; ++i) {
    for (int j = 0; j < pairings; ++j) {
      const double variance = shared_m * shared_m + (i == j ? own_m * own_m : 0.0);
      S.block<2, 2>(2 * i, 2 * j) = variance * Matrix2d::Identity();
    }
  }
  return S;
}

TEST(PairingEvidence, IsTheLikelihoodOverTheDensityOfOtherObjects) {
  const Vector2d innovation(0.1, -0.2);
  const Matrix2d S = Vector2d(0.04, 0.09).asDiagonal();
  const double likelihood =
      std::exp(-0.5 * (0.1 * 0.1 / 0.04 + 0.2 * 0.2 / 0.09)) / (2.0 * kPi * std::sqrt(0.04 * 0.09));
  EXPECT_NEAR(logOdds({0}, {pairing(0, innovation)}, S), std::log(likelihood / kDensity), 1e-12);
}

TEST(PairingEvidence, DoesNotDependOnTheOrder) {
  const std::vector<Pairing> pairings = {pairing(0, {2.0, 1.0}), pairing(1, {2.1, 1.0}),
                                         pairing(2, {1.9, 1.1})};
  const MatrixXd S = sharedError(3, 2.0, 0.1);
  EXPECT_NEAR(logOdds({0, 1, 2}, pairings, S), logOdds({2, 0, 1}, pairings, S), 1e-9);
}

TEST(PairingEvidence, OneMatchIsPlentyWhereThePlaceIsWellKnown) {
  const std::vector<Pairing> pairings = {pairing(0, {0.05, 0.05})};
  EXPECT_THAT(provenPairings({0}, pairings, sharedError(1, 0.05, 0.05), kOneInAHundred),
              ElementsAre(0));
}

TEST(PairingEvidence, OneMatchProvesNothingWhereAnyObjectMightBe) {
  const std::vector<Pairing> pairings = {pairing(0, {0.5, 0.5})};
  EXPECT_THAT(provenPairings({0}, pairings, sharedError(1, 3.0, 0.05), kOneInAHundred), IsEmpty());
}

TEST(PairingEvidence, SeveralThatAgreeProveEachOther) {
  const std::vector<Pairing> pairings = {pairing(0, {2.0, 1.0}), pairing(1, {2.05, 1.0})};
  EXPECT_THAT(provenPairings({0, 1}, pairings, sharedError(2, 3.0, 0.05), kOneInAHundred),
              ElementsAre(0, 1));
}

// A strong group must not carry one along that proves nothing by itself: the vehicle knows where it
// is among what it saw lately, and may still not know where that is among what it saw long ago.
TEST(PairingEvidence, AStrongGroupCarriesNoCoincidenceAlong) {
  const std::vector<Pairing> pairings = {pairing(0, {0.05, 0.0}), pairing(1, {0.0, 0.05}),
                                         pairing(2, {1.0, 1.0})};
  MatrixXd S = MatrixXd::Zero(6, 6);
  S.topLeftCorner<4, 4>() = sharedError(2, 0.05, 0.05);
  S.bottomRightCorner<2, 2>() = 9.0 * Matrix2d::Identity();
  EXPECT_THAT(provenPairings({0, 1, 2}, pairings, S, kOneInAHundred), ElementsAre(0, 1));
}

TEST(PairingEvidence, ACovarianceThatIsNoneProvesNothing) {
  EXPECT_EQ(logOdds({0}, {pairing(0, {0.0, 0.0})}, Matrix2d::Zero()),
            -std::numeric_limits<double>::infinity());
}

/// Two observations of trees in a row, four metres apart: each may be of any.
std::vector<Pairing> inARow(const std::vector<double>& offsets) {
  std::vector<Pairing> pairings;
  for (int observation = 0; observation < 2; ++observation) {
    for (const double offset : offsets) {
      const int tree = observation + static_cast<int>(std::lround(offset / 4.0));
      pairings.push_back({observation, tree, Vector2d(offset, 0.1), 0.0, kDensity});
    }
  }
  return pairings;
}

std::vector<int> undisputed(const std::vector<Pairing>& pairings, double shared_m) {
  const JointCompatibility joint({18.0, 0.9999, 20000});
  const MatrixXd S = sharedError(static_cast<int>(pairings.size()), shared_m, 0.05);
  const JointHypothesis best = joint.find(pairings, S, 2);
  return undisputedPairings(joint, best.pairings, pairings, S, kOneInAHundred);
}

TEST(UndisputedPairings, AreNoneAmongTreesOfARowThatAllFit) {
  EXPECT_THAT(undisputed(inARow({-4.0, 0.1, 4.0}), 5.0), IsEmpty());
}

TEST(UndisputedPairings, AreAllWhereOtherTreesAreTooFarOff) {
  EXPECT_THAT(undisputed(inARow({-4.0, 0.1, 4.0}), 1.0), ElementsAre(1, 4));
}

TEST(UndisputedPairings, AreAllWhereThereIsNothingElse) {
  EXPECT_THAT(undisputed(inARow({4.0}), 5.0), ElementsAre(0, 1));
}

TEST(UndisputedPairings, KeepWhatRivalsShare) {
  // The third observation is of one tree in either case.
  std::vector<Pairing> pairings = inARow({0.0, 0.2});
  pairings[1].landmark = 7;
  pairings[3].landmark = 8;
  pairings.push_back({2, 9, Vector2d(0.1, 0.0), 0.0, kDensity});
  const JointCompatibility joint({18.0, 0.9999, 20000});
  const MatrixXd S = sharedError(5, 0.3, 0.2);
  const JointHypothesis best = joint.find(pairings, S, 3);
  EXPECT_EQ(best.paired, 3);
  EXPECT_THAT(undisputedPairings(joint, best.pairings, pairings, S, kOneInAHundred),
              ElementsAre(4));
}

}  // namespace
}  // namespace hymm::core
