#include "pipeline/recorded_samples.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hymm::core {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

RecordedSample sampleAt(double time_s, std::optional<Pose2> T_base_frame) {
  RecordedSample recorded;
  recorded.sample.sample.time_s = time_s;
  recorded.sample.position = {1.0, 0.0};
  recorded.sample.covariance = Eigen::Vector2d(0.04, 0.01).asDiagonal();
  recorded.T_base_frame = T_base_frame;
  return recorded;
}

TEST(RecordedSamples, OfMapStayWhereTheyAre) {
  RecordedSamples samples;
  samples.add(sampleAt(1.0, std::nullopt));
  const auto placed = samples.takePlaced({1.2, {10.0, 0.0, 1.0}});
  ASSERT_THAT(placed, SizeIs(1));
  EXPECT_EQ(placed[0].position, Eigen::Vector2d(1.0, 0.0));
}

TEST(RecordedSamples, OfTheVehicleArePlacedBetweenTheScansAroundTheirTime) {
  RecordedSamples samples;
  samples.add(sampleAt(1.1, Pose2{2.0, 0.0, 0.0}));
  EXPECT_THAT(samples.takePlaced({1.0, {10.0, 0.0, 1.5}}), IsEmpty());
  const auto placed = samples.takePlaced({1.4, {10.0, 4.0, 1.7}});
  ASSERT_THAT(placed, SizeIs(1));
  const Eigen::Vector2d expected = Pose2{10.0, 1.0, 1.55} * Eigen::Vector2d(3.0, 0.0);
  EXPECT_TRUE(placed[0].position.isApprox(expected, 1e-12));
  // Its covariance turns along.
  const Eigen::Vector2d forward(std::cos(1.55), std::sin(1.55));
  EXPECT_NEAR(forward.dot(placed[0].covariance * forward), 0.04, 1e-12);
  EXPECT_EQ(samples.withoutPlace(), 0U);
}

TEST(RecordedSamples, ThatComeLateAreStillPlaced) {
  RecordedSamples samples;
  for (double time_s = 0.0; time_s < 3.0; time_s += 0.5) samples.takePlaced({time_s, {}});
  samples.add(sampleAt(1.0, Pose2()));
  EXPECT_THAT(samples.takePlaced({3.0, {}}), SizeIs(1));
}

TEST(RecordedSamples, WithoutAPoseAtTheirTimeAreCounted) {
  RecordedSamples samples;
  samples.add(sampleAt(0.5, Pose2()));  // before the first pose
  samples.add(sampleAt(2.5, Pose2()));  // in a gap
  samples.add(sampleAt(9.0, Pose2()));  // after the last
  EXPECT_THAT(samples.takePlaced({1.0, {}}), IsEmpty());
  EXPECT_THAT(samples.takePlaced({4.0, {}}), IsEmpty());
  EXPECT_EQ(samples.withoutPlace(), 3U);
}

TEST(RecordedSamples, AreNotPlacedAcrossWhatWasForgotten) {
  RecordedSamples samples;
  samples.takePlaced({1.0, {}});
  samples.add(sampleAt(1.1, Pose2()));
  samples.forgetPoses();
  EXPECT_THAT(samples.takePlaced({1.2, {}}), IsEmpty());
  EXPECT_EQ(samples.withoutPlace(), 1U);
}

}  // namespace
}  // namespace hymm::core
