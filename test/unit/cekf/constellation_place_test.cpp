#include "cekf/constellation_place.h"

#include <gtest/gtest.h>

#include "common/angles.h"
#include "common/random.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;

constexpr double kCoincidence = 0.001;

/// Trees at random in a square, and a vehicle among them whose place is hardly known.
struct Wood {
  explicit Wood(std::uint64_t seed, int trees = 60, double side_m = 80.0) : generator(seed) {
    for (int k = 0; k < trees; ++k) {
      question.landmarks.push_back(
          {{sampleUniform(generator, 0.0, side_m), sampleUniform(generator, 0.0, side_m)},
           0.01,
           LandmarkType::kTrunk});
    }
    truth = {sampleUniform(generator, 0.3 * side_m, 0.7 * side_m),
             sampleUniform(generator, 0.3 * side_m, 0.7 * side_m),
             sampleUniform(generator, -kPi, kPi)};
    question.expected = {0.5 * side_m, 0.5 * side_m, 0.0};
    question.covariance = Eigen::Vector3d(400.0, 400.0, 10.0).asDiagonal();
  }

  /// What is in reach of the true pose.
  void see(double range_m = 20.0) {
    for (const auto& landmark : question.landmarks) {
      const Vector2d place = inverse(truth) * landmark.position;
      if (place.norm() > range_m) continue;
      question.seen.push_back({place + noise(), 1e-3, landmark.type});
    }
  }
  void seeUnmapped(int things, double range_m = 20.0) {
    for (int k = 0; k < things; ++k) {
      question.seen.push_back({{sampleUniform(generator, -range_m, range_m),
                                sampleUniform(generator, -range_m, range_m)},
                               1e-3,
                               LandmarkType::kTrunk});
    }
  }
  Vector2d noise() { return {sampleNormal(generator, 0.03), sampleNormal(generator, 0.03)}; }

  RandomGenerator generator;
  SeenConstellation question;
  Pose2 truth;
};

TEST(ConstellationPlace, FindsTheVehicleWhereverItIsAndHoweverItIsTurned) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Wood wood(seed);
    wood.see();
    const auto place = findConstellationPlace(wood.question, kCoincidence);
    if (!place) continue;
    ++found;
    EXPECT_LT((place->T_map_base.position() - wood.truth.position()).norm(), 0.2) << seed;
    EXPECT_LT(std::abs(wrapAngle(place->T_map_base.yaw_rad - wood.truth.yaw_rad)), 0.02) << seed;
    ASSERT_EQ(place->landmarks.size(), wood.question.seen.size());
  }
  EXPECT_GE(found, 19);  // some place has few trees in reach
}

TEST(ConstellationPlace, BearsThatHalfOfWhatIsSeenIsNotInTheMap) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Wood wood(seed, 120);
    wood.see();
    wood.seeUnmapped(static_cast<int>(wood.question.seen.size()));
    const auto place = findConstellationPlace(wood.question, kCoincidence);
    if (!place) continue;
    ++found;
    EXPECT_LT((place->T_map_base.position() - wood.truth.position()).norm(), 0.2) << seed;
  }
  EXPECT_GE(found, 18);
}

TEST(ConstellationPlace, NowhereIsFoundWhatIsNotInTheMap) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Wood wood(seed);
    wood.seeUnmapped(15);
    EXPECT_FALSE(findConstellationPlace(wood.question, kCoincidence)) << seed;
  }
}

TEST(ConstellationPlace, OfTwoPlacesThatLookAlikeNoneIsBelieved) {
  Wood wood(3, 30, 40.0);
  wood.see();
  const auto trees = wood.question.landmarks;
  for (auto tree : trees) {
    tree.position.x() += 50.0;
    wood.question.landmarks.push_back(tree);
  }
  wood.question.covariance(0, 0) = 1e4;
  EXPECT_FALSE(findConstellationPlace(wood.question, kCoincidence));
  // One tree that stands in one of them only, and is seen, tells which.
  for (const Vector2d& extra : {Vector2d(3.0, 4.0), Vector2d(-6.0, 2.0)}) {
    wood.question.landmarks.push_back({wood.truth * extra, 0.01, LandmarkType::kTrunk});
    wood.question.seen.push_back({extra, 1e-3, LandmarkType::kTrunk});
  }
  const auto place = findConstellationPlace(wood.question, kCoincidence);
  ASSERT_TRUE(place);
  EXPECT_LT((place->T_map_base.position() - wood.truth.position()).norm(), 0.2);
}

TEST(ConstellationPlace, LooksOnlyWhereTheVehicleMayBe) {
  Wood wood(5);
  wood.see();
  ASSERT_TRUE(findConstellationPlace(wood.question, kCoincidence));
  wood.question.covariance.diagonal() << 1.0, 1.0, 10.0;
  wood.question.expected.x_m = wood.truth.x_m + 10.0;
  EXPECT_FALSE(findConstellationPlace(wood.question, kCoincidence));
}

TEST(ConstellationPlace, TellsTypesApart) {
  Wood wood(5);
  wood.see();
  for (auto& seen : wood.question.seen) seen.type = LandmarkType::kReflector;
  EXPECT_FALSE(findConstellationPlace(wood.question, kCoincidence));
}

TEST(ConstellationPlace, IsNothingWhereNothingIsSeenOrMapped) {
  Wood wood(5);
  EXPECT_FALSE(findConstellationPlace(wood.question, kCoincidence));
  wood.see();
  wood.question.landmarks.clear();
  EXPECT_FALSE(findConstellationPlace(wood.question, kCoincidence));
}

}  // namespace
}  // namespace hymm::core
