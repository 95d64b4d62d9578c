// What is told of a pose is no more certain than the particles and the observations let it be.

#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gmock/gmock.h>

#include "common/random.h"
#include "relocaliser/observed_bound.h"
#include "relocaliser/particle_modes.h"
#include "tree_stand.h"

namespace hymm::core {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const BinSize kBin{0.5, 0.1};

/// Spread evenly through a box about the origin and weighed by a Gaussian about the truth.
ParticleSet weighedParticles(const Vector3d& truth, const Vector3d& deviation, int count,
                             RandomGenerator& generator) {
  const Vector3d half(0.7, 0.7, 0.14);
  ParticleSet particles;
  for (int i = 0; i < count; ++i) {
    Vector3d pose;
    for (int k = 0; k < 3; ++k) pose[k] = sampleUniform(generator, -half[k], half[k]);
    const Vector3d off = (pose - truth).cwiseQuotient(deviation);
    particles.add(Pose2::fromVector(pose), static_cast<float>(-0.5 * off.squaredNorm()));
  }
  normaliseWeights(particles);
  return particles;
}

double meanNees(const Vector3d& deviation, int count) {
  RandomGenerator generator(7);
  constexpr int kTrials = 400;
  double sum = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Vector3d truth(sampleUniform(generator, -0.2, 0.2), sampleUniform(generator, -0.2, 0.2),
                         sampleUniform(generator, -0.04, 0.04));
    // The likelihood is not about the truth either, but about what was measured.
    Vector3d measured = truth;
    for (int k = 0; k < 3; ++k) measured[k] += sampleNormal(generator, deviation[k]);
    const auto modes =
        computeModes(weighedParticles(measured, deviation, count, generator), kBin, 1e-4);
    const Vector3d error = modes.front().mean.vector() - truth;
    sum += error.dot(modes.front().covariance.inverse() * error);
  }
  return sum / kTrials;
}

// Chi-square of 3 degrees of freedom has mean 3; that of 400 trials is within 0.37 of it in 99.7 %.
TEST(ToldCovariance, IsConsistentWhereManyParticlesAreEffective) {
  EXPECT_NEAR(meanNees({0.1, 0.1, 0.02}, 20000), 3.0, 0.37);
}

TEST(ToldCovariance, CoversTheErrorWhereTheWeightsFallOnOneParticle) {
  EXPECT_LT(meanNees({0.005, 0.005, 0.001}, 2000), 3.37);
  EXPECT_LT(meanNees({0.0005, 0.0005, 0.0001}, 200), 3.37);
}

TEST(ToldCovariance, IsThatOfTheBinsWhereAParticleStandsAlone) {
  ParticleSet particles;
  particles.add({1.0, 2.0, 0.3});
  const auto modes = computeModes(particles, kBin, 1e-4);
  ASSERT_EQ(modes.size(), 1U);
  EXPECT_EQ(modes.front().effective_number, 1.0);
  EXPECT_NEAR(modes.front().covariance(0, 0), 1.5 * 1.5 / 12.0, 1e-12);
  EXPECT_NEAR(modes.front().covariance(2, 2), 0.3 * 0.3 / 12.0, 1e-12);
}

TEST(ToldCovariance, DoesNotCareHowFarTheWeightsHaveCollapsed) {
  ParticleSet particles;
  RandomGenerator generator(3);
  for (int i = 0; i < 500; ++i) {
    particles.add({sampleUniform(generator, -0.2, 0.2), sampleUniform(generator, -0.2, 0.2),
                   sampleUniform(generator, -0.04, 0.04)},
                  i == 0 ? 0.0F : -1e6F);
  }
  normaliseWeights(particles);
  const auto modes = computeModes(particles, kBin, 1e-4);
  EXPECT_GT(std::sqrt(modes.front().covariance(0, 0)), 0.05);
  EXPECT_LT(std::sqrt(modes.front().covariance(0, 0)), 0.5);
}

TEST(RaisedTo, RaisesWhatIsBelowAndLeavesWhatIsAbove) {
  const Matrix3d bound = Vector3d(0.01, 0.04, 0.0001).asDiagonal();
  const Matrix3d covariance = Vector3d(1e-10, 0.09, 0.0).asDiagonal();
  const Matrix3d raised = raisedTo(covariance, bound);
  EXPECT_TRUE(raised.isApprox(Matrix3d(Vector3d(0.01, 0.09, 0.0001).asDiagonal()), 1e-9)) << raised;
  EXPECT_TRUE(raisedTo(4.0 * bound, bound).isApprox(4.0 * bound, 1e-9));
}

Explanation explanationOf(double of_points, double of_landmarks) {
  Explanation explanation;
  explanation.of_points = of_points * Matrix3d::Identity();
  explanation.of_landmarks = of_landmarks * Matrix3d::Identity();
  return explanation;
}

// Of the points the errors average out; those of the landmarks stay.
TEST(ObservedBound, FallsToTheLandmarksOwnErrorsAndNoFarther) {
  ObservedBound bound;
  bound.beginAnywhere();
  const Explanation explanation = explanationOf(100.0, 400.0);
  bound.observe({}, explanation);
  EXPECT_NEAR(bound.covariance()(0, 0), 0.01 + 0.0025, 1e-6);
  for (int i = 1; i < 100; ++i) bound.observe({}, explanation);
  EXPECT_NEAR(bound.covariance()(0, 0), 0.0001 + 0.0025, 1e-6);
}

TEST(ObservedBound, GrowsWithTheMotion) {
  ObservedBound bound;
  bound.begin({{0.0, 0.0, kPi / 2.0}, 1e-6 * Matrix3d::Identity()});
  bound.move({2.0, 0.0, 0.0}, Vector3d(0.09, 0.01, 0.0).asDiagonal());
  EXPECT_NEAR(bound.covariance()(0, 0), 0.01, 1e-5);
  EXPECT_NEAR(bound.covariance()(1, 1), 0.09, 1e-5);
}

// A vehicle that stands sees the same landmarks, with the same errors, again and again.
TEST(Relocaliser, NeverTellsLessThanTheLandmarksOwnErrors) {
  LocalMap map = stand();
  for (LocalLandmark& landmark : map.landmarks) landmark.covariance *= 16.0;
  Relocaliser relocaliser(RelocaliserConfig{}, vehicle(), Calibration{}, RandomGenerator(1));
  relocaliser.begin(map, 0.0);
  Pose2 pose{1.5, -2.0, 0.08};
  double time_s = 0.0;
  for (int i = 0; i < 10; ++i) {
    relocaliser.process(TwistInput{time_s, 0.0, 0.0, 0.0, std::nullopt});
    time_s += kScanPeriod_s;
    const auto outcome = relocaliser.process(seenFrom(pose, map.landmarks, time_s));
    ASSERT_TRUE(outcome);
    const Matrix3d least = outcome->explanation.of_landmarks.inverse();
    const Eigen::SelfAdjointEigenSolver<Matrix3d> apart(outcome->modes.front().covariance - least);
    EXPECT_GT(apart.eigenvalues().minCoeff(), -1e-9) << "scan " << i;
  }
}

TEST(Relocaliser, DoesNotTakeACollapseOfTheWeightsForConvergence) {
  RelocaliserConfig config;
  config.initial_particles = 1000;
  config.particles.min_particles = 100;
  LocalMap map = stand();
  map.vehicle.covariance = Vector3d(400.0, 400.0, 1.0).asDiagonal();
  int collapsed = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Relocaliser relocaliser(config, vehicle(), Calibration{}, RandomGenerator(seed));
    relocaliser.begin(map, 0.0);
    const Pose2 pose{1.5, -2.0, 0.08};
    const auto outcome = relocaliser.process(seenFrom(pose, map.landmarks, 1.0));
    ASSERT_TRUE(outcome);
    if (outcome->effective_number > 5.0) continue;
    ++collapsed;
    EXPECT_EQ(outcome->held_scans, 0) << "seed " << seed << ", " << outcome->effective_number;
  }
  EXPECT_GT(collapsed, 0);
}

}  // namespace
}  // namespace hymm::core
