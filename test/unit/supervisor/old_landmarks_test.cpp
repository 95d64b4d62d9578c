#include "supervisor/old_landmarks.h"

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

LandmarkEstimate landmarkAt(double x_m, double y_m, double first_seen_s = 0.0) {
  LandmarkEstimate landmark;
  landmark.position = {x_m, y_m};
  landmark.observations = 20;
  landmark.first_seen_s = first_seen_s;
  return landmark;
}

TEST(OldLandmarks, CountsThoseWithinRangeAndAngleOfTheSensor) {
  const std::vector<LandmarkEstimate> landmarks = {landmarkAt(10.0, 14.0), landmarkAt(10.0, 30.0),
                                                   landmarkAt(10.0, -4.0)};
  const Pose2 facing_up{10.0, 0.0, kPi / 2.0};
  EXPECT_EQ(countOldLandmarksInView(landmarks, facing_up, 100.0, {}).expected, 1);
}

TEST(OldLandmarks, LeavesOutThoseThatTheVehicleHasJustFound) {
  const OldLandmarkConfig config;
  const double now_s = 100.0;
  const std::vector<LandmarkEstimate> landmarks = {
      landmarkAt(5.0, 0.0, now_s - config.age_s - 1.0),
      landmarkAt(6.0, 0.0, now_s - config.age_s + 1.0)};
  EXPECT_EQ(countOldLandmarksInView(landmarks, {}, now_s, config).expected, 1);
}

TEST(OldLandmarks, LeavesOutThoseThatAreHardlyEverSeen) {
  const OldLandmarkConfig config;
  LandmarkEstimate rare = landmarkAt(5.0, 0.0);
  rare.observations = config.least_observations - 1;
  EXPECT_EQ(countOldLandmarksInView({rare}, {}, 100.0, config).expected, 0);
}

TEST(OldLandmarks, TellWhichHaveNotBeenSeenLately) {
  const OldLandmarkConfig config;
  std::vector<LandmarkEstimate> landmarks = {landmarkAt(5.0, 0.0), landmarkAt(6.0, 1.0)};
  landmarks[0].last_seen_s = 100.0 - 0.5 * config.unseen_s;
  landmarks[1].last_seen_s = 100.0 - 1.5 * config.unseen_s;
  const OldLandmarksInView view = countOldLandmarksInView(landmarks, {}, 100.0, config);
  EXPECT_EQ(view.expected, 2);
  EXPECT_EQ(view.unseen, 1);
  EXPECT_EQ(view.unseenShare(), 0.5);
  EXPECT_EQ(OldLandmarksInView{}.unseenShare(), 0.0);
}

}  // namespace
}  // namespace hymm::core
