#include "evaluation/constellation.h"

#include <gtest/gtest.h>

#include "common/random.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;

std::vector<Vector2d> scattered(int count, std::uint64_t seed) {
  RandomGenerator generator(seed);
  std::vector<Vector2d> points;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(sampleUniform(generator, -100.0, 100.0),
                        sampleUniform(generator, -80.0, 80.0));
  }
  return points;
}

TEST(Constellation, IsFoundInALargerSurveyWithErrorsAndFalseLandmarks) {
  const std::vector<Vector2d> truth = scattered(120, 1);
  const Pose2 T{4000.0, -700.0, -2.4};
  RandomGenerator generator(2);
  std::vector<Vector2d> estimates;
  for (int i = 0; i < 60; ++i) {
    const Vector2d error(sampleNormal(generator, 0.1), sampleNormal(generator, 0.1));
    estimates.push_back(inverse(T) * truth[static_cast<std::size_t>(2 * i)] + error);
  }
  for (const Vector2d& p : scattered(20, 3)) estimates.push_back(p);
  const auto found = findConstellation(estimates, truth, 0.5);
  ASSERT_TRUE(found);
  for (int i = 0; i < 60; ++i) {
    const auto at = static_cast<std::size_t>(i);
    EXPECT_LT((*found * estimates[at] - truth[2 * at]).norm(), 1.0);
  }
}

TEST(Constellation, IsNotFoundAmongOtherLandmarks) {
  EXPECT_FALSE(findConstellation(scattered(40, 4), scattered(40, 5), 0.5));
  EXPECT_FALSE(findConstellation({}, scattered(40, 5), 0.5));
  EXPECT_FALSE(findConstellation(scattered(4, 6), scattered(4, 6), 0.5));
}

}  // namespace
}  // namespace hymm::core
