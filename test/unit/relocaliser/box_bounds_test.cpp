#include "relocaliser/box_bounds.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "common/angles.h"
#include "common/random.h"

namespace hymm::core {
namespace {

constexpr double kView_m2 = 1400.0;

// Tables are of floats: a hundred values of a few nats are rounded by less.
constexpr double kRounding = 1e-4;

/// Points in heaps, some of them at one place, of a few classes.
std::vector<ArmPoint> heaps(RandomGenerator& generator) {
  std::vector<ArmPoint> points;
  for (int heap = 0; heap < 20; ++heap) {
    const Eigen::Vector2d middle(sampleUniform(generator, -25.0, 25.0),
                                 sampleUniform(generator, -25.0, 25.0));
    for (int i = 0; i < heap % 6 + 1; ++i) {
      const double spread_m = heap % 4 == 0 ? 0.0 : 0.1;
      const Eigen::Vector2d error(sampleNormal(generator, spread_m),
                                  sampleNormal(generator, spread_m));
      points.push_back({middle + error, static_cast<std::size_t>(i % 3)});
    }
  }
  return points;
}

TEST(PointTree, HasEachPointInOneGroupThatTellsHowFarItIs) {
  RandomGenerator generator(1);
  std::vector<ArmPoint> points = heaps(generator);
  const PointTree tree(points);
  for (const double most_m : {0.0, 0.2, 3.0, 100.0}) {
    std::vector<int> seen(points.size(), 0);
    const auto groups = tree.cut([&](const PointGroup& group) { return group.within_m <= most_m; });
    for (const PointGroup& group : groups) {
      EXPECT_LE(group.within_m, most_m);
      std::set<std::size_t> classes;
      for (std::size_t k = group.begin; k < group.end; ++k) {
        ++seen[k];
        classes.insert(points[k].deviation);
        EXPECT_LE((points[k].arm - group.arm).norm(), group.within_m);
        EXPECT_LE(points[k].arm.norm(), group.longest_m);
      }
      EXPECT_EQ(group.is_of_one_class, classes.size() == 1);
    }
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<long>(points.size()));
  }
}

TEST(PointTree, CutsIntoFewerGroupsWhereLargerOnesAreAccepted) {
  RandomGenerator generator(2);
  std::vector<ArmPoint> points = heaps(generator);
  const PointTree tree(points);
  const auto count = [&](double most_m) {
    return tree.cut([&](const PointGroup& group) { return group.within_m <= most_m; }).size();
  };
  EXPECT_EQ(count(1000.0), 1U);
  EXPECT_GT(count(3.0), 1U);
  EXPECT_LE(count(0.5), 30U);  // of twenty heaps, few are divided
  EXPECT_LT(count(0.5), points.size() / 2);
}

TEST(PointTree, PartsPointsAtOnePlaceByTheirClass) {
  std::vector<ArmPoint> points;
  for (std::size_t i = 0; i < 7; ++i) points.push_back({{3.0, 4.0}, i % 2});
  const PointTree tree(points);
  const auto groups = tree.cut([](const PointGroup&) { return false; });
  ASSERT_EQ(groups.size(), 2U);
  EXPECT_EQ(groups[0].size(), 4U);  // the heaviest first
  EXPECT_EQ(groups[1].size(), 3U);
  for (const PointGroup& group : groups) {
    EXPECT_TRUE(group.is_of_one_class);
    EXPECT_EQ(group.longest_m, 5.0);
  }
}

struct Scene {
  std::vector<LocalLandmark> landmarks;
  std::vector<ObservedPoint> points;

  explicit Scene(std::uint64_t seed) {
    RandomGenerator generator(seed);
    const double side_m = sampleUniform(generator, 15.0, 50.0);
    for (int i = 0; i < 25; ++i) {
      const Eigen::Vector2d place(sampleUniform(generator, 0.0, side_m),
                                  sampleUniform(generator, 0.0, side_m));
      Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
      for (double& a : A.reshaped()) a = sampleNormal(generator, 0.2);
      landmarks.push_back({i, place, A * A.transpose()});
    }
    // A landmark is seen several times, as well known as it is then, and now and then the same.
    for (std::size_t k = 0; k < 80; ++k) {
      const Eigen::Vector2d error(sampleNormal(generator, 0.05), sampleNormal(generator, 0.05));
      const Eigen::Vector2d place =
          landmarks[k % 20].position + (k % 3 == 0 ? Eigen::Vector2d::Zero() : error);
      const double deviation_m = roundedUpDeviation(sampleUniform(generator, 0.15, 1.0));
      points.push_back({place.cast<float>(), deviation_m, place.norm()});
    }
  }
  double clutterPerM2() const { return core::clutterPerM2(points.size(), kView_m2, {}); }
  /// What they are worth where the middle of the points comes to lie there.
  double valueAt(const PoseBox& pose, const BoxBounds& bounds) const {
    const Pose2 turned{0.0, 0.0, wrapAngle(pose.yaw_rad)};
    const Eigen::Vector2d place = pose.middle - turned * bounds.middle();
    return logLikelihoodAt({place.x(), place.y(), turned.yaw_rad}, landmarks, points, kView_m2, {});
  }
};

BoxBounds prepared(const Scene& scene) {
  BoxBounds bounds(scene.landmarks, scene.points, scene.clutterPerM2());
  bounds.makeLevels(4.0, bounds.halfYaw_rad(4.0));
  while (bounds.prepare()) {
  }
  return bounds;
}

/// The box of that level that holds a pose; the one of the first level is around it at random.
PoseBox boxAround(const PoseBox& pose, const BoxBounds& bounds, std::size_t level,
                  const PoseBox& parent, RandomGenerator& generator) {
  const double half_m = bounds.half_m(level), half_yaw = bounds.half_yaw_rad(level);
  if (level > 0) {
    const auto side = [](double off) { return off < 0.0 ? -1.0 : 1.0; };
    const Eigen::Vector2d off = pose.middle - parent.middle;
    return {parent.middle + half_m * Eigen::Vector2d(side(off.x()), side(off.y())),
            parent.yaw_rad + half_yaw * side(pose.yaw_rad - parent.yaw_rad)};
  }
  const Eigen::Vector2d off(sampleUniform(generator, -1.0, 1.0),
                            sampleUniform(generator, -1.0, 1.0));
  return {pose.middle + half_m * off,
          pose.yaw_rad + half_yaw * sampleUniform(generator, -1.0, 1.0)};
}

/// At the true place, near it, or anywhere.
PoseBox poseSomewhere(const BoxBounds& bounds, int i, RandomGenerator& generator) {
  if (i % 3 == 2) {
    return {{sampleUniform(generator, -20.0, 70.0), sampleUniform(generator, -20.0, 70.0)},
            sampleUniform(generator, -kPi, kPi)};
  }
  const double share = i % 3 == 0 ? 0.0 : 1.0;
  return {bounds.middle() +
              share * Eigen::Vector2d(sampleNormal(generator, 0.5), sampleNormal(generator, 0.5)),
          share * sampleNormal(generator, 0.05)};
}

// The proof that there is no rival rests on this.
TEST(BoxBounds, AreNeverBelowTheLikelihoodAtAPoseOfTheBox) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Scene scene(seed);
    BoxBounds bounds = prepared(scene);
    RandomGenerator generator(100 + seed);
    for (int i = 0; i < 60; ++i) {
      const PoseBox pose = poseSomewhere(bounds, i, generator);
      const double value = scene.valueAt(pose, bounds);
      PoseBox box;
      for (std::size_t level = 0; level < bounds.levels(); ++level) {
        box = boxAround(pose, bounds, level, box, generator);
        EXPECT_GE(bounds.bound(level, box, -1.0), value - kRounding)
            << "seed " << seed << " pose " << i << " level " << level;
      }
    }
  }
}

TEST(BoxBounds, ExcludeNoBoxThatHoldsMoreThanIsNeeded) {
  const Scene scene(3);
  BoxBounds bounds = prepared(scene);
  RandomGenerator generator(3);
  for (int i = 0; i < 200; ++i) {
    const PoseBox pose = poseSomewhere(bounds, i, generator);
    const double needed = scene.valueAt(pose, bounds) - kRounding;
    PoseBox box;
    for (std::size_t level = 0; level < bounds.levels(); ++level) {
      box = boxAround(pose, bounds, level, box, generator);
      ASSERT_GT(bounds.bound(level, box, needed), needed) << "pose " << i << " level " << level;
    }
  }
}

// In the last boxes a point moves by a 32nd of its deviation, so at four deviations, the farthest
// that counts, it comes nearer by a 16th of one from any pose of the box: 4 / 16 nats.
TEST(BoxBounds, ComeNearToTheLikelihoodInTheEnd) {
  const Scene scene(5);
  BoxBounds bounds = prepared(scene);
  RandomGenerator generator(5);
  for (int i = 0; i < 60; ++i) {
    const PoseBox pose = poseSomewhere(bounds, i, generator);
    PoseBox box;
    double bound = 0.0;
    for (std::size_t level = 0; level < bounds.levels(); ++level) {
      box = boxAround(pose, bounds, level, box, generator);
      bound = bounds.bound(level, box, -1.0);
    }
    EXPECT_LE(bound, scene.valueAt(pose, bounds) + 0.25 * static_cast<double>(scene.points.size()));
    EXPECT_NEAR(bounds.valueAt(box), scene.valueAt(box, bounds), kRounding);
  }
}

}  // namespace
}  // namespace hymm::core
