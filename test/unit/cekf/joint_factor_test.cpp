#include "cekf/joint_factor.h"

#include <cmath>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "cekf/hypothesis_without.h"
#include "common/random.h"

namespace hymm::core {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Six pairings of any covariance.
class SixPairings : public testing::Test {
 protected:
  SixPairings() {
    RandomGenerator generator(3);
    MatrixXd root(12, 12);
    for (double& value : root.reshaped()) value = sampleNormal(generator, 1.0);
    S_ = root * root.transpose() + MatrixXd::Identity(12, 12);
    for (int k = 0; k < 6; ++k) {
      Pairing pairing;
      pairing.innovation << sampleNormal(generator, 2.0), sampleNormal(generator, 2.0);
      pairings_.push_back(pairing);
    }
  }

  MatrixXd covarianceOf(const std::vector<int>& chosen) const {
    const auto n = static_cast<Eigen::Index>(chosen.size());
    MatrixXd joint(2 * n, 2 * n);
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = 0; j < n; ++j) {
        joint.block<2, 2>(2 * i, 2 * j) = S_.block<2, 2>(2 * chosen[static_cast<std::size_t>(i)],
                                                         2 * chosen[static_cast<std::size_t>(j)]);
      }
    }
    return joint;
  }

  double distance2Of(const std::vector<int>& chosen) const {
    VectorXd innovations(2 * chosen.size());
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      innovations.segment<2>(2 * static_cast<Eigen::Index>(i)) =
          pairings_[static_cast<std::size_t>(chosen[i])].innovation;
    }
    return innovations.dot(covarianceOf(chosen).inverse() * innovations);
  }

  /// The sums of what putting these one behind the other adds.
  static JointFactor::Addition sumOf(JointFactor& factor, const std::vector<int>& chosen) {
    JointFactor::Addition sum{0.0, 0.0};
    for (std::size_t place = 0; place < chosen.size(); ++place) {
      const JointFactor::Addition added = factor.put(place, chosen[place]);
      sum.distance2 += added.distance2;
      sum.log_deviations += added.log_deviations;
    }
    return sum;
  }

  std::vector<Pairing> pairings_;
  MatrixXd S_;
};

TEST_F(SixPairings, AddUpToTheJointDistanceAndDeterminant) {
  JointFactor factor(pairings_, S_, 6);
  for (const std::vector<int>& chosen : {std::vector<int>{4}, {0, 1, 2, 3, 4, 5}, {5, 2, 0}}) {
    const JointFactor::Addition sum = sumOf(factor, chosen);
    EXPECT_NEAR(sum.distance2, distance2Of(chosen), 1e-10);
    EXPECT_NEAR(sum.log_deviations, 0.5 * std::log(covarianceOf(chosen).determinant()), 1e-10);
  }
}

TEST_F(SixPairings, BehindOneThatWasReplacedAreComputedAnew) {
  JointFactor factor(pairings_, S_, 6);
  sumOf(factor, {0, 1, 2, 3});
  factor.put(1, 5);
  factor.put(2, 2);  // stood there before, but behind another
  EXPECT_NEAR(sumOf(factor, {0, 5, 2}).distance2, distance2Of({0, 5, 2}), 1e-10);
}

TEST_F(SixPairings, OfACovarianceThatIsNoneAreInfinitelyFar) {
  S_(4, 4) = -1.0;
  JointFactor factor(pairings_, S_, 6);
  EXPECT_TRUE(std::isinf(factor.put(0, 2).distance2));
  EXPECT_FALSE(std::isinf(factor.put(0, 1).distance2));
}

TEST_F(SixPairings, WithoutSomeOfThemAreAsFarAsTheOthersAlone) {
  HypothesisWithout hypothesis(pairings_, S_, {5, 0, 3, 1});
  EXPECT_NEAR(hypothesis.distance2(), distance2Of({5, 0, 3, 1}), 1e-10);
  hypothesis.leaveOut(3);
  EXPECT_NEAR(hypothesis.distance2(), distance2Of({5, 0, 1}), 1e-10);
  hypothesis.leaveOut(5);
  EXPECT_NEAR(hypothesis.distance2(), distance2Of({0, 1}), 1e-10);
  hypothesis.takeBack();
  hypothesis.leaveOut(0);
  EXPECT_NEAR(hypothesis.distance2(), distance2Of({5, 1}), 1e-10);
  EXPECT_TRUE(hypothesis.has(5));
  EXPECT_FALSE(hypothesis.has(2));
}

}  // namespace
}  // namespace hymm::core
