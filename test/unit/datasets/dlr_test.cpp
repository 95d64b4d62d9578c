#include <gmock/gmock.h>

#include "common/error.h"
#include "datasets/landmark_recording.h"
#include "support/recordings.h"
#include "support/temporary_folder.h"
#include "vehicle/motion_model.h"

namespace hymm::core {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr char kStep[] =
    "STEP image.ppm 0.1 -0.4 0.2 0.0004 0.0001 0.0009 0.00002 0.00003 0.0016\n";

LandmarkRecording read(const std::string& text) {
  const test::TemporaryFolder folder;
  return readDlr(folder.write("map.circles", text));
}

const TwistInput& twistOf(const SensorEvent& event) {
  return std::get<TwistInput>(std::get<MotionInput>(event));
}

TEST(Dlr, StepMovesVehicleByDisplacementWithItsCovariance) {
  const LandmarkRecording recording = read(kStep);
  const MotionStep step =
      MotionModel(VehicleConfig{})
          .step(Pose2{}, twistOf(recording.events.at(0)), Calibration{}, 0.0, kDlrStep_s);
  // X is right, -Y forward, angles clockwise.
  EXPECT_NEAR(step.pose.x_m, 0.4, 1e-14);
  EXPECT_NEAR(step.pose.y_m, -0.1, 1e-14);
  EXPECT_NEAR(step.pose.yaw_rad, -0.2, 1e-14);
  const Eigen::Matrix3d expected = (Eigen::Matrix3d() << 0.0009, 0.0001, 0.00003,  //
                                    0.0001, 0.0004, 0.00002,                       //
                                    0.00003, 0.00002, 0.0016)
                                       .finished();
  EXPECT_LT((step.noise - expected).norm(), 1e-15);
}

TEST(Dlr, LandmarkAheadAndToTheRightHasNegativeBearing) {
  const LandmarkRecording recording =
      read(std::string(kStep) + "LANDMARK_C 3 -4 0.9 0.01 0.0 0.04 17\n");
  const auto& set = std::get<ObservationSet>(recording.events.at(1));
  ASSERT_EQ(set.observations.size(), 1u);
  EXPECT_DOUBLE_EQ(set.time_s, kDlrStep_s);
  const Observation& observation = set.observations[0];
  EXPECT_EQ(observation.identity, 17);
  EXPECT_DOUBLE_EQ(observation.range_m, 5.0);
  EXPECT_DOUBLE_EQ(observation.bearing_rad, -std::atan2(3.0, 4.0));
  // Along the ray (0.8 forward, -0.6 left): 0.64 * 0.04 + 0.36 * 0.01.
  EXPECT_NEAR(observation.covariance(0, 0), 0.0292, 1e-15);
  // Across it, over 5 m: (0.36 * 0.04 + 0.64 * 0.01) / 25.
  EXPECT_NEAR(observation.covariance(1, 1), 0.000832, 1e-15);
  EXPECT_DOUBLE_EQ(observation.covariance(0, 1), observation.covariance(1, 0));
}

TEST(Dlr, SeveralIdentitiesOrNoneAreNotIdentified) {
  const LandmarkRecording recording = read(std::string(kStep) +
                                           "LANDMARK_C 1 -1 0.9 0.01 0 0.01 4 5\n"
                                           "LANDMARK 1 -2 0.9 0.01 0 0.01 -1\n"
                                           "LANDMARK_C 1 -3 0.9 0.01 0.05 0.01 6\n");
  const auto& observations = std::get<ObservationSet>(recording.events.at(1)).observations;
  ASSERT_EQ(observations.size(), 2u);  // the third has an impossible covariance
  EXPECT_EQ(observations[0].identity, -1);
  EXPECT_EQ(observations[1].identity, -1);
  ASSERT_EQ(recording.counts.size(), 3u);
  for (const ReadingCount& count : recording.counts) EXPECT_EQ(count.count, 1u) << count.what;
}

TEST(Dlr, VehicleStandsStillAfterItsLastStep) {
  const LandmarkRecording recording = read(std::string(kStep) + kStep);
  ASSERT_EQ(recording.events.size(), 5u);  // step, what was seen, step, what was seen, stop
  EXPECT_DOUBLE_EQ(twistOf(recording.events[4]).time_s, 2.0 * kDlrStep_s);
  EXPECT_EQ(twistOf(recording.events[4]).forward_mps, 0.0);
}

TEST(Dlr, NamesLineOfWhatItCannotRead) {
  const auto refuses = [](const std::string& text, const std::string& part) {
    EXPECT_THAT([&] { read(text); }, ThrowsMessage<InputError>(HasSubstr(part)));
  };
  refuses(std::string(kStep) + "STEP image 0.1 0.2\n", "line 2: has 4 fields instead of 11");
  refuses(std::string("# head\n") + kStep + "LANDMARK_C 1 x 0.9 0.01 0 0.01 4\n",
          "line 3: 'x' is not a finite number");
  refuses(std::string(kStep) + "LANDMARK_C 1 2 0.9 0.01 x 0.01 4\n",
          "line 2: 'x' is not a finite number");
  refuses(std::string(kStep) + "LANDMARK_C 1 2 0.9 0.01 0 0.01 4.5\n", "'4.5' is not an identity");
  refuses("LANDMARK_C 1 2 0.9 0.01 0 0.01 4\n", "line 1: a landmark comes before the first step");
  refuses("GIF89a", "begins with 'GIF89a'");
  refuses("", "holds no STEP line");
  refuses("STEP i 0.1 -0.4 0.2 -1 0 1 0 0 1\n", "not positive semi-definite");
}

TEST(Dlr, RefusesMissingFile) {
  EXPECT_THAT([] { readDlr("/does/not/exist"); },
              ThrowsMessage<InputError>(HasSubstr("/does/not/exist cannot be read")));
}

TEST(Dlr, ReadsPublishedRecording) {
  HYMM_SKIP_WITHOUT_RECORDING("dlr/map.circles");
  const LandmarkRecording recording = readDlr(test::recording("dlr"));
  std::size_t steps = 0, observations = 0, identified = 0;
  for (const SensorEvent& event : recording.events) {
    if (std::holds_alternative<MotionInput>(event)) ++steps;
    const auto* set = std::get_if<ObservationSet>(&event);
    if (set == nullptr) continue;
    observations += set->observations.size();
    for (const Observation& o : set->observations) identified += o.identity >= 0 ? 1 : 0;
  }
  EXPECT_EQ(steps, 3297u + 1u);
  EXPECT_EQ(observations, 14745u);
  EXPECT_EQ(identified, 14309u);
}

}  // namespace
}  // namespace hymm::core
