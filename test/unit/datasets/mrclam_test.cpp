#include <gmock/gmock.h>

#include "common/error.h"
#include "datasets/landmark_recording.h"
#include "pipeline/sensor_event.h"
#include "support/recordings.h"
#include "support/temporary_folder.h"

namespace hymm::core {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr char kArchive[] = "mrclam/mrclam_ds6_robots12.zip";

/// A recording of robot 3 with two landmarks (subjects 6 and 7) and one other robot (subject 1).
class Mrclam : public testing::Test {
 protected:
  Mrclam() {
    folder_.write("Barcodes.dat", "# Subject # Barcode\n 1 \t 5 \n 6 \t 72\n 7 \t 27\n");
    folder_.write("Landmark_Groundtruth.dat", "6 1.5 -2.5 0.01 0.02\n7 3 4 0.01 0.02\n");
    folder_.write("Robot3_Groundtruth.dat", "100.0 1 2 3.2\n100.1 1 2 3.3\n");
    folder_.write("Robot3_Odometry.dat", "100.0 0.5 0.1\n100.2 0.6 0.1\n100.2 0.7 0.1\n");
    folder_.write("Robot3_Measurement.dat",
                  "100.1 72 2.0 0.5\n100.1 27 3.0 -0.5\n100.2 5 1 0\n100.3 99 1 0\n100.4 72 2 0\n");
  }

  LandmarkRecording read() const { return readMrclam(folder_.path(), 3); }

  std::size_t countOf(const std::string& part) const {
    for (const ReadingCount& count : read().counts) {
      if (count.what.find(part) != std::string::npos) return count.count;
    }
    return 0;
  }

  test::TemporaryFolder folder_;
};

TEST_F(Mrclam, ObservationsOfOneImageFormOneSetWithSubjectsAsIdentities) {
  const LandmarkRecording recording = read();
  ASSERT_EQ(recording.events.size(), 4u);
  const auto& set = std::get<ObservationSet>(recording.events[1]);
  EXPECT_DOUBLE_EQ(set.time_s, 100.1);
  ASSERT_EQ(set.observations.size(), 2u);
  EXPECT_EQ(set.observations[0].identity, 6);
  EXPECT_EQ(set.observations[1].identity, 7);
  EXPECT_DOUBLE_EQ(set.observations[1].range_m, 3.0);
  EXPECT_DOUBLE_EQ(set.observations[1].bearing_rad, -0.5);
}

TEST_F(Mrclam, EventsComeInTimeOrder) {
  double last_s = 0.0;
  for (const SensorEvent& event : read().events) {
    EXPECT_GE(timeOf(event), last_s);
    last_s = timeOf(event);
  }
}

TEST_F(Mrclam, CountsWhatItSkips) {
  EXPECT_EQ(countOf("other robots"), 1u);
  EXPECT_EQ(countOf("unknown barcodes"), 1u);
  EXPECT_EQ(countOf("not later"), 1u);
}

TEST_F(Mrclam, ReadsTruth) {
  const LandmarkRecording recording = read();
  ASSERT_EQ(recording.truth_poses.size(), 2u);
  EXPECT_DOUBLE_EQ(recording.truth_poses[0].T_world_base.yaw_rad, 3.2 - 2.0 * kPi);
  ASSERT_EQ(recording.truth_landmarks.size(), 2u);
  EXPECT_EQ(recording.truth_landmarks[0].identity, 6);
  EXPECT_EQ(recording.truth_landmarks[0].position, Eigen::Vector2d(1.5, -2.5));
  EXPECT_EQ(recording.truth_landmarks[0].deviation, Eigen::Vector2d(0.01, 0.02));
}

TEST_F(Mrclam, MayComeWithoutTruth) {
  std::filesystem::remove(folder_.path() / "Landmark_Groundtruth.dat");
  std::filesystem::remove(folder_.path() / "Robot3_Groundtruth.dat");
  const LandmarkRecording recording = read();
  EXPECT_TRUE(recording.truth_poses.empty());
  EXPECT_TRUE(recording.truth_landmarks.empty());
  EXPECT_FALSE(recording.events.empty());
}

TEST_F(Mrclam, NamesRobotThatIsNotThere) {
  EXPECT_THAT([&] { readMrclam(folder_.path(), 4); },
              ThrowsMessage<InputError>(HasSubstr("holds no file Robot4_Odometry.dat")));
}

TEST_F(Mrclam, NamesLineOfWhatIsNotANumber) {
  folder_.write("Robot3_Odometry.dat", "# head\n100.0 0.5 0.1\n100.2 fast 0.1\n");
  EXPECT_THAT([&] { read(); }, ThrowsMessage<InputError>(HasSubstr("line 3, character 7: 'fast'")));
}

TEST_F(Mrclam, RefusesNumbersThatAreNotFinite) {
  folder_.write("Robot3_Odometry.dat", "100.0 0.5 nan\n");
  EXPECT_THAT([&] { read(); },
              ThrowsMessage<InputError>(HasSubstr("row 1 holds a number that is")));
}

TEST_F(Mrclam, RefusesBarcodeThatIsNoWholeNumber) {
  folder_.write("Robot3_Measurement.dat", "100.1 72.5 2.0 0.5\n");
  EXPECT_THAT([&] { read(); }, ThrowsMessage<InputError>(
                                   HasSubstr("Measurement.dat: row 1 has 72.5 where a whole")));
}

TEST_F(Mrclam, SkipsRangesThatAreNotPositive) {
  folder_.write("Robot3_Measurement.dat", "100.1 72 0 0.5\n100.1 72 -2 0.5\n");
  EXPECT_EQ(countOf("range is not positive"), 2u);
}

TEST(MrclamRecording, ReadsPublishedSet) {
  HYMM_SKIP_WITHOUT_RECORDING(kArchive);
  const LandmarkRecording recording = readMrclam(test::recording(kArchive), 1);
  std::size_t motion = 0, observations = 0;
  for (const SensorEvent& event : recording.events) {
    if (std::holds_alternative<MotionInput>(event)) ++motion;
    const auto* set = std::get_if<ObservationSet>(&event);
    if (set != nullptr) observations += set->observations.size();
  }
  EXPECT_EQ(recording.truth_landmarks.size(), 15u);
  EXPECT_EQ(observations, 1942u - 407u - 1u);
  ASSERT_EQ(recording.counts.size(), 2u);
  EXPECT_EQ(recording.counts[0].count, 407u);  // of other robots
  EXPECT_EQ(recording.counts[1].count, 1u);    // unknown
}

}  // namespace
}  // namespace hymm::core
