#include "evaluation/rigid_alignment.h"

#include <gtest/gtest.h>

#include "common/random.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;

TEST(RigidAlignment, RecoversARigidMotionExactly) {
  const Pose2 T_to_from{120.0, -40.0, 2.3};
  RandomGenerator generator(3);
  RigidAlignment alignment;
  for (int i = 0; i < 50; ++i) {
    const Vector2d p(sampleNormal(generator, 100.0), sampleNormal(generator, 100.0));
    alignment.add(p, T_to_from * p);
  }
  const Pose2 found = alignment.T_to_from();
  EXPECT_NEAR(found.x_m, 120.0, 1e-11);
  EXPECT_NEAR(found.y_m, -40.0, 1e-11);
  EXPECT_NEAR(found.yaw_rad, 2.3, 1e-13);
  EXPECT_NEAR(alignment.squaredError(), 0.0, 1e-8);
}

TEST(RigidAlignment, SquaredErrorIsWhatItsTransformLeaves) {
  RandomGenerator generator(4);
  std::vector<std::pair<Vector2d, Vector2d>> pairs;
  RigidAlignment alignment;
  for (int i = 0; i < 100; ++i) {
    const Vector2d from(sampleNormal(generator, 80.0), sampleNormal(generator, 20.0));
    const Vector2d noise(sampleNormal(generator, 0.9), sampleNormal(generator, 0.9));
    const Vector2d to = Pose2{1e6, 5e6, -0.7} * from + noise;
    pairs.emplace_back(from, to);
    alignment.add(from, to);
  }
  double left = 0.0;
  for (const auto& [from, to] : pairs) left += (alignment.T_to_from() * from - to).squaredNorm();
  EXPECT_NEAR(alignment.squaredError(), left, 1e-6 * left);
}

TEST(RigidAlignment, NoOtherTransformLeavesLess) {
  RandomGenerator generator(5);
  std::vector<std::pair<Vector2d, Vector2d>> pairs;
  RigidAlignment alignment;
  for (int i = 0; i < 30; ++i) {
    const Vector2d from(sampleNormal(generator, 10.0), sampleNormal(generator, 10.0));
    const Vector2d to(sampleNormal(generator, 10.0), sampleNormal(generator, 10.0));
    pairs.emplace_back(from, to);
    alignment.add(from, to);
  }
  const Pose2 best = alignment.T_to_from();
  for (const Pose2& step : {Pose2{0.01, 0, 0}, Pose2{-0.01, 0, 0}, Pose2{0, 0.01, 0},
                            Pose2{0, -0.01, 0}, Pose2{0, 0, 0.01}, Pose2{0, 0, -0.01}}) {
    double left = 0.0;
    for (const auto& [from, to] : pairs) left += (step * best * from - to).squaredNorm();
    EXPECT_GT(left, alignment.squaredError());
  }
}

TEST(RigidAlignment, DoesNotScale) {
  RigidAlignment alignment;
  alignment.add({-1.0, 0.0}, {-2.0, 0.0});
  alignment.add({1.0, 0.0}, {2.0, 0.0});
  EXPECT_NEAR(alignment.squaredError(), 2.0, 1e-12);
}

}  // namespace
}  // namespace hymm::core
