#include "evaluation/landmark_error.h"

#include <cmath>

#include <gtest/gtest.h>

#include "common/random.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;

std::vector<Vector2d> grid() {
  std::vector<Vector2d> positions;
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 6; ++j) positions.emplace_back(7.0 * i + 0.3 * j, 5.0 * j - 0.2 * i * i);
  }
  return positions;
}

std::vector<LandmarkEstimate> estimatesAt(const std::vector<Vector2d>& positions) {
  std::vector<LandmarkEstimate> estimates(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    estimates[i].position = positions[i];
    estimates[i].covariance = 0.01 * Eigen::Matrix2d::Identity();
  }
  return estimates;
}

const std::vector<StampedPose> kPoses = {{0.0, {0.0, 0.0, 0.0}}, {10.0, {50.0, 10.0, 0.0}}};

TEST(LandmarkErrors, SmallTurnOfTheMapIsAlignedAway) {
  const Pose2 T{0.2, -0.1, 0.01};
  std::vector<Vector2d> moved;
  for (const Vector2d& p : grid()) moved.push_back(T * p);
  const auto errors = computeLandmarkErrors(estimatesAt(moved), grid(), kPoses, {});
  ASSERT_TRUE(errors);
  EXPECT_EQ(errors->distance_m.count, grid().size());
  EXPECT_NEAR(errors->aligned_distance_m.max, 0.0, 1e-12);
  EXPECT_GT(errors->distance_m.rmse, 0.2);
  EXPECT_EQ(errors->false_landmarks, 0u);
  EXPECT_EQ(errors->missed, 0u);
}

TEST(LandmarkErrors, CountsFalseMissedAndUnseenLandmarks) {
  std::vector<Vector2d> truth = grid();
  std::vector<Vector2d> estimated = grid();
  estimated.emplace_back(20.0, -40.0);  // nothing there
  truth.emplace_back(4.0, -4.0);        // near the first pose, not found
  truth.emplace_back(500.0, 500.0);     // the vehicle never came near
  const auto errors = computeLandmarkErrors(estimatesAt(estimated), truth, kPoses, {});
  EXPECT_EQ(errors->false_landmarks, 1u);
  EXPECT_EQ(errors->missed, 1u);
  EXPECT_EQ(errors->out_of_range, 1u);
}

TEST(LandmarkErrors, TwoEstimatesOfOneLandmarkAreOneMatchAndOneFalse) {
  std::vector<Vector2d> estimated = grid();
  estimated.push_back(grid()[10] + Vector2d(0.3, 0.0));
  const auto errors = computeLandmarkErrors(estimatesAt(estimated), grid(), kPoses, {});
  EXPECT_EQ(errors->distance_m.count, grid().size());
  EXPECT_EQ(errors->false_landmarks, 1u);
  EXPECT_NEAR(errors->distance_m.max, 0.0, 1e-12);
}

TEST(LandmarkErrors, SecondEstimateOfALandmarkIsADuplicateAndOneInTheVoidIsNot) {
  std::vector<Vector2d> estimated = grid();
  estimated.push_back(grid()[10] + Vector2d(0.3, 0.0));
  estimated.emplace_back(20.0, -40.0);
  const auto errors = computeLandmarkErrors(estimatesAt(estimated), grid(), kPoses, {});
  EXPECT_EQ(errors->false_landmarks, 2u);
  EXPECT_EQ(errors->duplicates, 1u);
}

TEST(LandmarkErrors, TurnedMapIsMatchedFromAnotherGuessAndItsErrorsCountAsGiven) {
  const Pose2 T{3.0, -2.0, 0.05};
  std::vector<Vector2d> moved;
  for (const Vector2d& p : grid()) moved.push_back(T * p);
  LandmarkMatching matching;
  const auto given_alone = computeLandmarkErrors(estimatesAt(moved), grid(), kPoses, matching);
  EXPECT_TRUE(!given_alone || given_alone->distance_m.count < grid().size());
  matching.other_guesses = {inverse(T) * Pose2{0.2, 0.1, 0.0}};
  const auto errors = computeLandmarkErrors(estimatesAt(moved), grid(), kPoses, matching);
  ASSERT_TRUE(errors);
  EXPECT_EQ(errors->distance_m.count, grid().size());
  EXPECT_NEAR(errors->aligned_distance_m.max, 0.0, 1e-9);
  EXPECT_GT(errors->distance_m.rmse, 1.0);
}

TEST(LandmarkErrors, ErrorsDrawnFromTheCovarianceAreConsistent) {
  RandomGenerator generator(5);
  double mean = 0.0;
  constexpr int kRuns = 100;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<Vector2d> drawn;
    for (const Vector2d& p : grid()) {
      drawn.push_back(p + Vector2d(sampleNormal(generator, 0.1), sampleNormal(generator, 0.1)));
    }
    mean += computeLandmarkErrors(estimatesAt(drawn), grid(), kPoses, {})->nees.mean / kRuns;
  }
  EXPECT_NEAR(mean, 2.0, 4.0 * 2.0 / std::sqrt(48.0 * kRuns));
}

TEST(LandmarkErrors, NothingWithinTheGateIsNoResult) {
  EXPECT_FALSE(computeLandmarkErrors(estimatesAt({{100.0, 100.0}}), grid(), kPoses, {}));
  EXPECT_FALSE(computeLandmarkErrors({}, grid(), kPoses, {}));
}

}  // namespace
}  // namespace hymm::core
