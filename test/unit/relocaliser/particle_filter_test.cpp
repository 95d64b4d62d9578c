#include "relocaliser/particle_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gmock/gmock.h>

#include "relocaliser/density_map.h"
#include "relocaliser/particle_kernels.h"
#include "relocaliser/particle_modes.h"

namespace hymm::core {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::SizeIs;

ParticleSet particlesAt(const std::vector<Pose2>& poses) {
  ParticleSet particles;
  for (const Pose2& pose : poses) particles.add(pose);
  return particles;
}

LocalLandmark landmarkAt(double x, double y, double deviation_m = 0.1) {
  return {0, {x, y}, deviation_m * deviation_m * Eigen::Matrix2d::Identity()};
}

ObservedPoint pointAt(double x, double y, double deviation_m = 0.2) {
  return {Eigen::Vector2f(static_cast<float>(x), static_cast<float>(y)), deviation_m,
          std::hypot(x, y)};
}

TEST(ParticleKernels, LookUpWhatEachParticlePutsThePointOn) {
  // 4 x 3 cells of half a metre from (-1, 0); each holds its own number.
  std::vector<float> table(12);
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = static_cast<float>(i);
  const LookupGrid grid{-1.0F, 0.0F, 2.0F, 4, 3};
  const LookupPoint point{1.0F, 0.0F, table.data()};
  ParticleSet particles = particlesAt({{-1.4, 0.2, 0.0},       // point at (-0.4, 0.2): cell (1, 0)
                                       {0.2, 0.3, kPi / 2.0},  // (0.2, 1.3): cell (2, 2)
                                       {1.7, 0.7, -kPi},       // (0.7, 0.7): cell (3, 1)
                                       {100.0, 100.0, 0.0},    // beyond: the last cell
                                       {-100.0, -100.0, 0.0}});  // the first
  addLookups(grid, &point, 1, particles);
  EXPECT_THAT(particles.log_weight, ElementsAre(1.0F, 10.0F, 7.0F, 11.0F, 0.0F));
}

TEST(ParticleKernels, AddLookupsOfAnyNumberOfPoints) {
  const std::vector<float> table{0.5F};
  const LookupGrid grid;
  const std::vector<LookupPoint> points(21, LookupPoint{0.0F, 0.0F, table.data()});
  ParticleSet particles;
  for (int i = 0; i < 1500; ++i) particles.add({});
  addLookups(grid, points.data(), points.size(), particles);
  EXPECT_THAT(particles.log_weight, Each(10.5F));
}

TEST(ParticleKernels, MoveEachParticleInItsOwnAxes) {
  NoisyStep step;
  step.mean << 2.0F, 1.0F, 0.5F;
  ParticleSet particles = particlesAt({{0.0, 0.0, 0.0}, {1.0, 2.0, kPi / 2.0}, {0.0, 0.0, 9.0}});
  moveParticles(step, 1, particles);
  const auto expectPose = [&](std::size_t i, const Pose2& pose) {
    EXPECT_NEAR(static_cast<double>(particles.x_m[i]), pose.x_m, 1e-6);
    EXPECT_NEAR(static_cast<double>(particles.y_m[i]), pose.y_m, 1e-6);
    EXPECT_NEAR(wrapAngle(static_cast<double>(particles.yaw_rad[i]) - pose.yaw_rad), 0.0, 1e-6);
  };
  const Pose2 T_step{2.0, 1.0, 0.5};
  expectPose(0, T_step);
  expectPose(1, Pose2{1.0, 2.0, kPi / 2.0} * T_step);
  expectPose(2, Pose2{0.0, 0.0, 9.0} * T_step);
}

TEST(ParticleKernels, SpreadParticlesAsTheCovarianceSays) {
  constexpr int kCount = 200000;
  const Eigen::Matrix3f root =
      (Eigen::Matrix3f() << 0.3F, 0.0F, 0.0F, 0.1F, 0.2F, 0.0F, 0.02F, -0.05F, 0.1F).finished();
  NoisyStep step;
  step.root = root;
  ParticleSet particles;
  for (int i = 0; i < kCount; ++i) particles.add({});
  moveParticles(step, 42, particles);
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const Eigen::Vector3d d = particles.pose(i).vector();
    first += d / kCount;
    second += d * d.transpose() / kCount;
  }
  const Eigen::Matrix3d expected = (root * root.transpose()).cast<double>();
  // Five deviations of a mean and of a variance estimated from so many samples.
  const double tolerance = 5.0 / std::sqrt(static_cast<double>(kCount));
  const Eigen::Vector3d deviation = expected.diagonal().cwiseSqrt();
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(first[i] / deviation[i], 0.0, tolerance);
    for (int j = 0; j < 3; ++j) {
      EXPECT_NEAR((second(i, j) - expected(i, j)) / (deviation[i] * deviation[j]), 0.0,
                  1.5 * tolerance);
    }
  }
}

TEST(ParticleKernels, NormaliseWeightsAgainstTheGreatest) {
  ParticleSet particles = particlesAt(std::vector<Pose2>(5));
  particles.log_weight = {1000.0F, 1000.0F + std::log(0.5F), 900.0F,
                          std::numeric_limits<float>::quiet_NaN(),
                          -std::numeric_limits<float>::infinity()};
  const WeightSums sums = normaliseWeights(particles);
  EXPECT_FLOAT_EQ(particles.weight[0], 1.0F);
  EXPECT_NEAR(static_cast<double>(particles.weight[1]), 0.5, 1e-4);  // 1000 in float
  EXPECT_EQ(particles.weight[2], 0.0F);
  EXPECT_EQ(particles.weight[3], 0.0F);
  EXPECT_EQ(particles.weight[4], 0.0F);
  EXPECT_NEAR(sums.effectiveNumber(), 1.5 * 1.5 / 1.25, 1e-3);
}

TEST(DensityMap, GivesTheLogarithmOfLandmarksAgainstClutter) {
  const double view_m2 = 500.0;
  DensityConfig config;
  config.clutter_share = 0.5;
  const std::vector<LocalLandmark> landmarks{landmarkAt(3.0, 1.0), landmarkAt(3.5, 1.0)};
  const std::vector<ObservedPoint> points{pointAt(3.0, 1.0), pointAt(8.0, 0.0)};
  const DensityMap density(landmarks, points, view_m2, config);
  // Both are normal with a variance of 0.05; clutter is two points over the view.
  const auto expected = [&](double x) {
    const double peak = 1.0 / (2.0 * kPi * 0.05);
    const double sum = peak * (std::exp(-0.5 * std::pow(x - 3.0, 2) / 0.05) +
                               std::exp(-0.5 * std::pow(x - 3.5, 2) / 0.05));
    return std::log1p(sum * view_m2 / 2.0);
  };
  for (const double x : {2.7, 3.0, 3.25, 3.6}) {
    // Within half a cell the density changes by its slope.
    const double slope = std::abs(expected(x + density.cell_m()) - expected(x - density.cell_m()));
    EXPECT_NEAR(density.logValueAt(0, {x, 1.0}), expected(x), 0.5 * slope + 0.05);
  }
  EXPECT_EQ(density.logValueAt(0, {-20.0, 50.0}), 0.0);
}

TEST(DensityMap, AgreesWithTheSumThatTakesNoTables) {
  const std::vector<LocalLandmark> landmarks{{0, {5.0, 2.0}, 0.04 * Eigen::Matrix2d::Identity()},
                                             {1, {5.5, 2.2}, 0.01 * Eigen::Matrix2d::Identity()},
                                             {2, {9.0, -3.0}, 0.09 * Eigen::Matrix2d::Identity()}};
  const std::vector<ObservedPoint> points{{{4.0F, 1.0F}, 0.3, 5.0}, {{8.1F, -4.0F}, 0.3, 9.0}};
  const DensityConfig config;
  const DensityMap map(landmarks, points, 1000.0, config);
  for (const Pose2& pose : {Pose2{1.0, 1.0, 0.0}, Pose2{0.9, 1.1, 0.02}, Pose2{-20.0, 7.0, 1.0}}) {
    double by_tables = 0.0;
    for (std::size_t k = 0; k < points.size(); ++k) {
      by_tables += map.logValueAt(k, pose * points[k].p_base_point.cast<double>());
    }
    EXPECT_NEAR(logLikelihoodAt(pose, landmarks, points, 1000.0, config), by_tables, 0.4);
  }
}

TEST(DensityMap, WithoutLandmarksOrPointsIsEvenEverywhere) {
  const DensityMap none({}, {pointAt(1.0, 0.0)}, 100.0, {});
  EXPECT_EQ(none.logValueAt(0, {1.0, 0.0}), 0.0);
  EXPECT_THAT(DensityMap({landmarkAt(0.0, 0.0)}, {}, 100.0, {}).lookups(), SizeIs(0));
}

TEST(LowVarianceResampling, DrawsEachAsOftenAsItsWeightSays) {
  const std::vector<float> weight{0.0F, 2.0F, 1.0F, 0.0F, 1.0F};
  for (const double start : {0.0, 0.3, 0.999}) {
    EXPECT_THAT(drawLowVariance(weight, 4, start), ElementsAre(1, 1, 2, 4)) << start;
  }
  EXPECT_THAT(drawLowVariance(weight, 8, 0.5), ElementsAre(1, 1, 1, 1, 2, 2, 4, 4));
}

// Fox (2003): for k - 1 degrees of freedom the number is chi-square's quantile over twice the
// error; Wilson and Hilferty's approximation of it is within a percent.
TEST(KldSampleNumber, IsTheQuantileOfChiSquareOverTwiceTheError) {
  EXPECT_NEAR(kldSampleNumber(11, 0.05, 2.3263), 23.209 / 0.1, 2.3);
  EXPECT_NEAR(kldSampleNumber(101, 0.05, 2.3263), 135.807 / 0.1, 14.0);
}

TEST(ParticleFilter, ResamplesOnlyWhenFewParticlesCarryTheWeight) {
  ParticleFilterConfig config;
  config.min_particles = 100;
  ParticleFilter filter(config);
  RandomGenerator generator(1);
  ParticleSet particles = particlesAt(std::vector<Pose2>(1000));
  filter.begin(particles);
  EXPECT_FALSE(filter.resampleIfDue(generator));
  for (std::size_t i = 100; i < 1000; ++i) particles.log_weight[i] = -50.0F;
  filter.begin(particles);
  EXPECT_NEAR(filter.effectiveNumber(), 100.0, 1e-3);
  EXPECT_TRUE(filter.resampleIfDue(generator));
}

TEST(ParticleFilter, TakesAsManyParticlesAsTheirSpreadNeeds) {
  RandomGenerator generator(1);
  const auto numberFor = [&](double spread_m) {
    ParticleFilterConfig config;
    config.resample_below = 1.0;
    config.min_particles = 500;
    ParticleFilter filter(config);
    ParticleSet particles;
    for (int i = 0; i < 20000; ++i) {
      particles.add({sampleNormal(generator, spread_m), sampleNormal(generator, spread_m), 0.0},
                    static_cast<float>(sampleUniform(generator, -1.0, 0.0)));
    }
    filter.begin(particles);
    EXPECT_TRUE(filter.resampleIfDue(generator));
    return filter.particles().size();
  };
  const std::size_t narrow = numberFor(0.05), wide = numberFor(5.0);
  EXPECT_EQ(narrow, 500U);
  EXPECT_GT(wide, 10U * narrow);
}

TEST(ParticleModes, TellApartWhatDoesNotHangTogether) {
  RandomGenerator generator(1);
  ParticleSet particles;
  for (int i = 0; i < 3000; ++i) {
    // One mode lies across the heading of half a turn.
    particles.add({5.0 + sampleNormal(generator, 0.1), sampleNormal(generator, 0.2),
                   kPi + sampleNormal(generator, 0.02)});
    if (i % 3 == 0) particles.add({-5.0, sampleNormal(generator, 0.1), 0.0});
  }
  const auto modes = computeModes(particles, {0.5, 0.1}, 0.01);
  ASSERT_THAT(modes, SizeIs(2));
  EXPECT_NEAR(modes[0].share, 0.75, 1e-6);
  EXPECT_NEAR(modes[0].mean.x_m, 5.0, 0.01);
  EXPECT_NEAR(wrapAngle(modes[0].mean.yaw_rad - kPi), 0.0, 0.002);
  EXPECT_NEAR(modes[0].covariance(1, 1), 0.04, 0.004);
  EXPECT_NEAR(modes[0].covariance(2, 2), 0.0004, 0.00004);
  EXPECT_NEAR(modes[1].mean.x_m, -5.0, 0.01);
}

}  // namespace
}  // namespace hymm::core
