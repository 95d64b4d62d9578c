#include "supervisor/old_landmarks.h"

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

constexpr double kNow_s = 100.0;
constexpr double kPeriod_s = 0.2;

LandmarkEstimate landmarkAt(double x_m, double y_m, double first_seen_s = 0.0) {
  LandmarkEstimate landmark;
  landmark.position = {x_m, y_m};
  landmark.observations = 20;
  landmark.first_seen_s = first_seen_s;
  landmark.last_seen_s = kNow_s;
  return landmark;
}

/// One that has looked from there for a while, with the landmarks in view as they are.
OldLandmarkWatch experienced(const std::vector<LandmarkEstimate>& landmarks,
                             const OldLandmarkConfig& config = {}, const Pose2& T_map_sensor = {}) {
  OldLandmarkWatch watch(config);
  for (int i = 0; i < 50; ++i) watch.look(landmarks, T_map_sensor, kNow_s);
  return watch;
}

TEST(OldLandmarks, ExpectsNothingBeforeItKnowsWhatTheSensorSees) {
  const std::vector<LandmarkEstimate> landmarks = {landmarkAt(5.0, 0.1)};
  OldLandmarkWatch watch{OldLandmarkConfig()};
  EXPECT_EQ(watch.look(landmarks, {}, kNow_s).expected, 0);
}

TEST(OldLandmarks, CountsThoseWithinRangeAndAngleOfTheSensor) {
  const std::vector<LandmarkEstimate> landmarks = {landmarkAt(10.0, 14.0), landmarkAt(10.0, 30.0),
                                                   landmarkAt(10.0, -4.0)};
  const Pose2 facing_up{10.0, 0.0, kPi / 2.0};
  EXPECT_EQ(experienced(landmarks, {}, facing_up).look(landmarks, facing_up, kNow_s).expected, 1);
}

TEST(OldLandmarks, LeavesOutThoseThatTheVehicleHasJustFound) {
  const OldLandmarkConfig config;
  const std::vector<LandmarkEstimate> landmarks = {
      landmarkAt(5.0, 0.1, kNow_s - config.age_s - 1.0),
      landmarkAt(6.0, 0.1, kNow_s - config.age_s + 1.0)};
  EXPECT_EQ(experienced(landmarks).look(landmarks, {}, kNow_s).expected, 1);
}

TEST(OldLandmarks, LeavesOutThoseThatAreHardlyEverSeen) {
  const OldLandmarkConfig config;
  LandmarkEstimate rare = landmarkAt(5.0, 0.1);
  rare.observations = config.least_observations - 1;
  EXPECT_EQ(experienced({rare}).look({rare}, {}, kNow_s).expected, 0);
}

TEST(OldLandmarks, TellWhichHaveNotBeenSeenLately) {
  const OldLandmarkConfig config;
  std::vector<LandmarkEstimate> landmarks = {landmarkAt(5.0, 0.1), landmarkAt(6.0, 0.2)};
  OldLandmarkWatch watch = experienced(landmarks);
  landmarks[0].last_seen_s = kNow_s - 0.5 * config.unseen_s;
  landmarks[1].last_seen_s = kNow_s - 1.5 * config.unseen_s;
  const OldLandmarksInView view = watch.look(landmarks, {}, kNow_s);
  EXPECT_EQ(view.expected, 2);
  EXPECT_EQ(view.unseen, 1);
  EXPECT_EQ(view.unseenShare(), 0.5);
  EXPECT_EQ(OldLandmarksInView{}.unseenShare(), 0.0);
}

TEST(OldLandmarks, ExpectsNothingWhereTheSensorNeverSawAny) {
  std::vector<LandmarkEstimate> landmarks = {landmarkAt(5.0, 0.1), landmarkAt(3.0, 6.0)};
  landmarks[1].last_seen_s = kNow_s - 50.0;  // at 63 degrees, beyond the sensor's field
  const OldLandmarksInView view = experienced(landmarks).look(landmarks, {}, kNow_s);
  EXPECT_EQ(view.expected, 1);
  EXPECT_EQ(view.unseen, 0);
}

TEST(OldLandmarks, GoesOnExpectingThemWhenTheFilterIsLost) {
  std::vector<LandmarkEstimate> landmarks = {landmarkAt(5.0, 0.1), landmarkAt(6.0, 0.2),
                                             landmarkAt(7.0, 0.3)};
  OldLandmarkWatch watch = experienced(landmarks);
  OldLandmarksInView view;
  for (double time_s = kNow_s; time_s < kNow_s + 4.0; time_s += kPeriod_s) {
    view = watch.look(landmarks, {}, time_s);
  }
  EXPECT_EQ(view.expected, 3);
  EXPECT_EQ(view.unseen, 3);
}

TEST(OldLandmarks, ForgetsWhatTheSensorSawInAnotherRecording) {
  const std::vector<LandmarkEstimate> landmarks = {landmarkAt(5.0, 0.1)};
  OldLandmarkWatch watch = experienced(landmarks);
  watch.clear();
  EXPECT_EQ(watch.look(landmarks, {}, kNow_s).expected, 0);
}

}  // namespace
}  // namespace hymm::core
