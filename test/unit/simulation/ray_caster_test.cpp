#include "simulation/ray_caster.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "common/random.h"

namespace hymm::core {
namespace {

Eigen::Vector2d directionOf(double angle_rad) { return {std::cos(angle_rad), std::sin(angle_rad)}; }

Solid disc(double x, double y, double radius) { return {Disc{{x, y}, radius}, {}, -1}; }

TEST(RayCaster, SeesNothingInAnEmptyWorld) {
  EXPECT_FALSE(RayCaster({}).cast({0.0, 0.0}, {1.0, 0.0}, 100.0));
}

TEST(RayCaster, MeetsTheNearSideOfADiscAtTheAnalyticRange) {
  const RayCaster caster({disc(10.0, 3.0, 0.5)});
  const double bearing = std::atan2(3.0, 10.0);
  const auto hit = caster.cast({0.0, 0.0}, directionOf(bearing), 100.0);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->range_m, std::hypot(10.0, 3.0) - 0.5, 1e-12);
  EXPECT_NEAR(hit->incidence_cosine, 1.0, 1e-9);
}

TEST(RayCaster, MissesADiscByAHair) {
  const RayCaster caster({disc(10.0, 0.0, 1.0)});
  const double tangent = std::asin(1.0 / 10.0);
  EXPECT_TRUE(caster.cast({0.0, 0.0}, directionOf(tangent - 1e-9), 100.0));
  EXPECT_FALSE(caster.cast({0.0, 0.0}, directionOf(tangent + 1e-9), 100.0));
}

TEST(RayCaster, MeetsAWallObliquely) {
  const RayCaster caster({{makeWall({5.0, -10.0}, {5.0, 10.0}, 0.2), {}, -1}});
  const double angle = 0.7;
  const auto hit = caster.cast({0.0, 0.0}, directionOf(angle), 100.0);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->range_m, 4.9 / std::cos(angle), 1e-9);
  EXPECT_NEAR(hit->incidence_cosine, std::cos(angle), 1e-9);
}

TEST(RayCaster, ReportsTheNearestOfThingsInLine) {
  const std::vector<Solid> solids = {disc(20.0, 0.0, 1.0), disc(8.0, 0.0, 1.0),
                                     disc(14.0, 0.0, 1.0)};
  const auto hit = RayCaster(solids).cast({0.0, 0.0}, {1.0, 0.0}, 100.0);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->solid, 1U);
  EXPECT_DOUBLE_EQ(hit->range_m, 7.0);
}

TEST(RayCaster, SeesNothingBeyondItsRange) {
  const RayCaster caster({disc(10.0, 0.0, 1.0)});
  EXPECT_TRUE(caster.cast({0.0, 0.0}, {1.0, 0.0}, 9.0));
  EXPECT_FALSE(caster.cast({0.0, 0.0}, {1.0, 0.0}, 8.999));
}

TEST(RayCaster, LooksIntoTheWorldFromOutside) {
  const auto hit = RayCaster({disc(0.0, 0.0, 1.0)}).cast({-500.0, 0.5}, {1.0, 0.0}, 1000.0);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->range_m, 500.0 - std::sqrt(0.75), 1e-9);
}

/// The grid must not change what is met: the same world in one large cell is the reference.
TEST(RayCaster, FindsTheSameWithAndWithoutGrid) {
  RandomGenerator generator(7);
  std::vector<Solid> solids;
  for (int i = 0; i < 120; ++i) {
    const Pose2 pose{sampleUniform(generator, -40.0, 40.0), sampleUniform(generator, -40.0, 40.0),
                     sampleUniform(generator, -kPi, kPi)};
    if (i % 2 == 0) {
      solids.push_back(disc(pose.x_m, pose.y_m, sampleUniform(generator, 0.05, 1.0)));
    } else {
      solids.push_back({makeBox(pose, sampleUniform(generator, 0.1, 12.0), 0.7, 0.1), {}, -1});
    }
  }
  const RayCaster gridded(solids, 3.0), whole(solids, 1000.0);
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector2d origin(sampleUniform(generator, -60.0, 60.0),
                                 sampleUniform(generator, -60.0, 60.0));
    const Eigen::Vector2d direction =
        directionOf(i % 10 == 0 ? kPi / 2.0 * (i / 10 % 4) : sampleUniform(generator, -kPi, kPi));
    const double range = sampleUniform(generator, 1.0, 150.0);
    const auto a = gridded.cast(origin, direction, range), b = whole.cast(origin, direction, range);
    ASSERT_EQ(a.has_value(), b.has_value()) << "ray " << i;
    if (!a) continue;
    ++hits;
    EXPECT_DOUBLE_EQ(a->range_m, b->range_m);
  }
  EXPECT_GT(hits, 5000);
}

TEST(Solid, DistanceIsZeroInsideAndEuclideanOutside) {
  const Shape box = makeBox({1.0, 2.0, kPi / 2.0}, 4.0, 2.0);
  EXPECT_EQ(distanceBetween({1.0, 2.0}, box), 0.0);
  EXPECT_NEAR(distanceBetween({2.5, 2.0}, box), 0.5, 1e-12);
  EXPECT_NEAR(distanceBetween({5.0, 8.0}, box), 5.0, 1e-12);
  EXPECT_NEAR(distanceBetween({3.0, 0.0}, Disc{{0.0, 0.0}, 1.0}), 2.0, 1e-12);
}

}  // namespace
}  // namespace hymm::core
