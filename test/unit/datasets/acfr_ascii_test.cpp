#include <cmath>

#include <gmock/gmock.h>

#include "common/angles.h"
#include "common/error.h"
#include "datasets/acfr_recording.h"
#include "support/acfr_files.h"
#include "support/recordings.h"

namespace hymm::core {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr char kArchive[] = "victoria_park/victoria_park_ascii.zip";
constexpr float kInf = std::numeric_limits<float>::infinity();

std::size_t countOf(const AcfrRecording& recording, const std::string& part) {
  for (const ReadingCount& count : recording.counts) {
    if (count.what.find(part) != std::string::npos) return count.count;
  }
  return 0;
}

class AcfrAscii : public testing::Test {
 protected:
  AcfrAscii() { test::writeAcfrAscii(folder_); }

  AcfrRecording read() const { return readAcfr({folder_.path()}); }

  void expectRefusal(const std::string& part) const {
    EXPECT_THAT([&] { read(); }, ThrowsMessage<InputError>(
                                     AllOf(HasSubstr(folder_.path().string()), HasSubstr(part))));
  }

  test::TemporaryFolder folder_;
};

TEST_F(AcfrAscii, FirstBeamPointsRightAndMiddleOneAhead) {
  const AcfrRecording recording = read();
  ASSERT_EQ(recording.scans.size(), 2u);
  const LaserScan& right = recording.scans[0];
  ASSERT_EQ(right.ranges_m.size(), 361u);
  EXPECT_FLOAT_EQ(right.ranges_m[0], 10.0f);
  EXPECT_DOUBLE_EQ(right.bearing(0), -kPi / 2.0);
  EXPECT_FLOAT_EQ(recording.scans[1].ranges_m[180], 20.5f);
  EXPECT_NEAR(right.bearing(180), 0.0, 1e-12);
  EXPECT_NEAR(right.bearing(360), kPi / 2.0, 1e-12);
}

TEST_F(AcfrAscii, EightyMetresAndMoreAreNoReturn) {
  folder_.write("LASER.txt",
                test::acfrScanText("0.5", 7, "79.99") + test::acfrScanText("0.7", 7, "80"));
  const AcfrRecording recording = read();
  EXPECT_FLOAT_EQ(recording.scans[0].ranges_m[7], 79.99f);
  EXPECT_EQ(recording.scans[0].ranges_m[8], kInf);
  EXPECT_EQ(recording.scans[1].ranges_m[7], kInf);
}

TEST_F(AcfrAscii, EventsKeepTheirOrderAndMissingRowsAreCounted) {
  const AcfrRecording recording = read();
  std::string order;
  for (const auto& event : recording.events) {
    order += "?GML"[static_cast<std::size_t>(event.sensor)] + std::to_string(event.index) + " ";
  }
  EXPECT_EQ(order, "G0 M0 L0 M1 G1 M2 L1 ");
  EXPECT_EQ(countOf(recording, "GPS events whose row is missing"), 1u);
  EXPECT_EQ(countOf(recording, "laser events whose row is missing"), 1u);
  EXPECT_EQ(recording.counts.size(), 2u);
}

TEST_F(AcfrAscii, TimeZeroBecomesOneNanosecond) { EXPECT_DOUBLE_EQ(read().fixes[0].time_s, 1e-9); }

TEST_F(AcfrAscii, LatitudeIsNorth) {
  const LocalFix fix = read().fixes[0];
  EXPECT_DOUBLE_EQ(fix.north_m, 3.0);
  EXPECT_DOUBLE_EQ(fix.east_m, 4.0);
}

TEST_F(AcfrAscii, SpeedAndSteeringAreAsRecorded) {
  const AckermannInput input = read().motion[1];
  EXPECT_DOUBLE_EQ(input.time_s, 0.5);
  EXPECT_DOUBLE_EQ(input.speed_mps, 2.0);
  EXPECT_DOUBLE_EQ(input.steering_rad, -0.1);
}

TEST_F(AcfrAscii, NegativeAndUndefinedRangesAreInvalidAndCounted) {
  folder_.write("LASER.txt",
                test::acfrScanText("0.5", 7, "-1") + test::acfrScanText("0.7", 8, "nan"));
  const AcfrRecording recording = read();
  EXPECT_TRUE(std::isnan(recording.scans[0].ranges_m[7]));
  EXPECT_TRUE(std::isnan(recording.scans[1].ranges_m[8]));
  EXPECT_EQ(countOf(recording, "negative or not a number"), 2u);
}

TEST_F(AcfrAscii, MotionThatIsNotFiniteIsSkippedAndCounted) {
  folder_.write("DRS.txt", "0.4 nan 0.1\n0.5 2 -0.1\n0.6 2 0\n");
  const AcfrRecording recording = read();
  EXPECT_EQ(countOf(recording, "speed or steering is not finite"), 1u);
  EXPECT_EQ(recording.events.size(), 6u);
}

TEST_F(AcfrAscii, CountsWhatDoesNotFitTogether) {
  folder_.write("Sensors_manager.txt", "0.5 3 1\n0.4 2 1\n0.61 2 3\n");
  const AcfrRecording recording = read();
  EXPECT_EQ(countOf(recording, "stamped before one that precedes"), 1u);
  EXPECT_EQ(countOf(recording, "stamp differs from their row's"), 1u);
  EXPECT_EQ(countOf(recording, "dead reckoning rows that no event refers to"), 1u);
  EXPECT_EQ(countOf(recording, "GPS rows that no event refers to"), 2u);
}

TEST_F(AcfrAscii, NamesPlaceOfWhatIsNotANumber) {
  folder_.write("LASER.txt",
                test::acfrScanText("0.5", 0, "10") + test::acfrScanText("0.7", 2, "oops"));
  expectRefusal("LASER.txt, line 1, character ");
  expectRefusal("'oops' is not a number (row 2, column 4)");
}

TEST_F(AcfrAscii, RefusesScanThatIsCutOff) {
  folder_.write("LASER.txt", test::acfrScanText("0.5", 0, "10") + "0.7\t12.0");
  expectRefusal("ends within row 2, after column 2 of 362");
}

TEST_F(AcfrAscii, RefusesImpossibleEventOrder) {
  folder_.write("Sensors_manager.txt", "0.5 3 1\n0.5 3 0\n");
  expectRefusal("Sensors_manager.txt, row 2: the index 0");
  folder_.write("Sensors_manager.txt", "0.5 3 1.5\n");
  expectRefusal("is not a row number");
  folder_.write("Sensors_manager.txt", "0.5 4 1\n");
  expectRefusal("row 1: the sensor is 4, but must be");
}

TEST_F(AcfrAscii, RefusesImpossibleStamps) {
  folder_.write("DRS.txt", "0.4 1 0\n-0.5 1 0\n");
  expectRefusal("DRS.txt, row 2: the time -0.5");
  folder_.write("DRS.txt", "inf 1 0\n");
  expectRefusal("DRS.txt, row 1: the time inf");
}

TEST_F(AcfrAscii, NamesFileThatIsMissingOrEmpty) {
  std::filesystem::remove(folder_.path() / "DRS.txt");
  expectRefusal("holds no file DRS.txt");
  folder_.write("DRS.txt", "");
  expectRefusal("DRS.txt holds no rows");
}

TEST_F(AcfrAscii, MayComeWithoutGpsAndWithoutAnOrderOfEvents) {
  std::filesystem::remove(folder_.path() / "GPS.txt");
  std::filesystem::remove(folder_.path() / "Sensors_manager.txt");
  const AcfrRecording recording = read();
  EXPECT_TRUE(recording.fixes.empty());
  ASSERT_EQ(recording.events.size(), recording.scans.size() + recording.motion.size());
  for (std::size_t i = 1; i < recording.events.size(); ++i) {
    EXPECT_LE(recording.timeOf(recording.events[i - 1]), recording.timeOf(recording.events[i]));
  }
}

TEST(ReadAcfr, RefusesWhatIsNoRecording) {
  const test::TemporaryFolder folder;
  EXPECT_THAT([&] { readAcfr({folder.path()}); },
              ThrowsMessage<InputError>(HasSubstr("holds neither LASER.txt nor .mat files")));
  EXPECT_THAT(
      [&] {
        readAcfr({folder.path(), folder.path()});
      },
      ThrowsMessage<InputError>(HasSubstr("Several inputs")));
  EXPECT_THAT([&] { readAcfr({folder.path() / "none"}); },
              ThrowsMessage<InputError>(HasSubstr("does not exist")));
}

TEST(AcfrRecordings, VictoriaParkHasAllItsRows) {
  HYMM_SKIP_WITHOUT_RECORDING(kArchive);
  const AcfrRecording recording = readAcfr({test::recording(kArchive)});
  EXPECT_EQ(recording.scans.size(), 7230u);
  EXPECT_EQ(recording.motion.size(), 61763u);
  EXPECT_EQ(recording.fixes.size(), 179u);
  EXPECT_EQ(recording.events.size(), 7230u + 61763u + 179u);
  ASSERT_EQ(recording.counts.size(), 1u);
  EXPECT_EQ(recording.counts[0].count, 948u - 179u);

  const LaserScan& first = recording.scans.front();
  EXPECT_DOUBLE_EQ(first.time_s, 0.852);
  EXPECT_FLOAT_EQ(first.ranges_m[0], 0.83f);
  EXPECT_FLOAT_EQ(first.ranges_m[11], 0.89f);
  EXPECT_EQ(first.ranges_m[12], kInf);
  EXPECT_DOUBLE_EQ(recording.scans.back().time_s, 1545.182);
  EXPECT_DOUBLE_EQ(recording.fixes.back().east_m, 118.71);
  EXPECT_DOUBLE_EQ(recording.fixes.back().north_m, 109.46);
}

}  // namespace
}  // namespace hymm::core
