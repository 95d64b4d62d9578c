#include <functional>
#include <utility>

#include <gtest/gtest.h>

#include "pipeline/sensor_merger.h"
#include "support/sensor_events.h"

namespace hymm::core {
namespace {

/// A drive with motion at 20 Hz, scans at 10 Hz and fixes at 1 Hz, in steps of 50 ms.
class SensorMergerDrive : public testing::Test {
 protected:
  static constexpr double kStep_s = 0.05;

  /// Steps from `first` on; each stamp is changed by its source's function.
  void drive(int first, int steps) {
    for (int i = first; i < first + steps; ++i) {
      const double time_s = 100.0 + kStep_s * i;
      give(motion(time_s + motion_ahead(i)));
      if (i % 2 == 0) give(detections(time_s - 0.01 + scan_ahead(i)));
      if (i % 20 == 0) give(fixAt(time_s + fix_ahead(i)));
    }
  }
  void driveToEnd() {
    drive(0, 2000);
    finish();
  }
  void give(SensorEvent event) {
    if (is_live) now_s += 0.01;
    merger.push(std::move(event), now_s);
    given.take(is_live ? merger.popReady(now_s) : merger.popReady());
  }
  void finish() { given.take(merger.flush()); }
  void beginAnew() {
    merger = SensorMerger({});
    given = EventTally();
  }

  using Ahead = std::function<double(int)>;
  static double right(int) { return 0.0; }
  static Ahead from(int step, double by_s) {
    return [=](int i) { return i >= step ? by_s : 0.0; };
  }
  static Ahead once(int step, double by_s) {
    return [=](int i) { return i == step ? by_s : 0.0; };
  }

  Ahead motion_ahead = right, scan_ahead = right, fix_ahead = right;
  SensorMerger merger{{}};
  EventTally given;
  bool is_live = true;  ///< else nothing times out
  double now_s = 0.0;
};

TEST_F(SensorMergerDrive, UsesEverythingThatIsInOrder) {
  driveToEnd();
  EXPECT_EQ(given.motions, 2000U);
  EXPECT_EQ(given.scans, 1000U);
  EXPECT_EQ(given.fixes, 100U);
  EXPECT_EQ(merger.counts().out_of_order, 0U);
  EXPECT_EQ(merger.counts().without_motion, 0U);
}

TEST_F(SensorMergerDrive, UsesAllScansAndMotionWhenTheGpsClockIsAhead) {
  for (const double by_s : {0.7, 5.0, 3600.0}) {
    SCOPED_TRACE(by_s);
    beginAnew();
    fix_ahead = from(0, by_s);
    drive(0, 2000);
    EXPECT_EQ(given.scans, 1000U);
    finish();
    EXPECT_EQ(given.motions, 2000U);
    EXPECT_EQ(given.scans, 1000U);
    EXPECT_EQ(merger.counts().dropped_scans, 0U);
    EXPECT_EQ(given.fixes + merger.counts().out_of_order, 100U);
  }
}

TEST_F(SensorMergerDrive, UsesFixesOfAClockThatIsAheadAtTheirStamps) {
  fix_ahead = from(0, 5.0);
  drive(0, 2000);
  EXPECT_EQ(given.fixes, 95U);
}

TEST_F(SensorMergerDrive, UsesAllScansAndMotionWhenTheGpsClockIsPutBack) {
  fix_ahead = from(1000, -20.0);
  driveToEnd();
  EXPECT_EQ(given.motions, 2000U);
  EXPECT_EQ(given.scans, 1000U);
  EXPECT_EQ(given.resets, 0U);
}

TEST_F(SensorMergerDrive, AStrayFixDelaysNothing) {
  fix_ahead = once(500, 100.0);
  driveToEnd();
  EXPECT_EQ(given.scans, 1000U);
  EXPECT_EQ(given.fixes, 99U);
}

TEST_F(SensorMergerDrive, DropsOneScanFarAheadAndNothingElse) {
  scan_ahead = once(1000, 100.0);
  driveToEnd();
  EXPECT_EQ(given.motions, 2000U);
  EXPECT_EQ(given.scans, 999U);
  EXPECT_EQ(given.fixes, 100U);
  EXPECT_EQ(given.resets, 0U);
  EXPECT_EQ(merger.counts().out_of_order, 1U);
  EXPECT_EQ(merger.counts().dropped_scans, 1U);
}

TEST_F(SensorMergerDrive, DropsOneMotionInputFarAheadAndNothingElse) {
  motion_ahead = once(1001, 100.0);
  driveToEnd();
  EXPECT_EQ(given.motions, 1999U);
  EXPECT_EQ(given.scans, 1000U);
  EXPECT_EQ(given.resets, 0U);
  EXPECT_EQ(merger.counts().out_of_order, 1U);
  EXPECT_EQ(merger.counts().dropped_scans, 0U);
}

TEST_F(SensorMergerDrive, RecoversFromAFirstStampThatIsStray) {
  for (Ahead* ahead : {&motion_ahead, &scan_ahead}) {
    beginAnew();
    motion_ahead = scan_ahead = right;
    *ahead = once(0, 100.0);
    driveToEnd();
    EXPECT_EQ(given.motions + given.scans + merger.counts().out_of_order, 3000U);
    EXPECT_LE(merger.counts().out_of_order, 3U);
    EXPECT_EQ(given.resets, 0U);
  }
}

TEST_F(SensorMergerDrive, LosesNothingToAGapThatAllSourcesShare) {
  motion_ahead = scan_ahead = fix_ahead = from(1000, 3600.0);
  driveToEnd();
  EXPECT_EQ(given.motions, 2000U);
  EXPECT_EQ(given.scans, 1000U);
  EXPECT_EQ(given.fixes, 100U);
  EXPECT_EQ(given.resets, 0U);
  EXPECT_EQ(merger.counts().without_motion, 0U);
}

TEST_F(SensorMergerDrive, BelievesAGapOnceMotionAndScansTogetherAgree) {
  drive(0, 200);
  give(motion(115.0));
  give(detections(115.0));
  EXPECT_EQ(given.scans, 100U);
  give(motion(115.05));
  EXPECT_EQ(given.motions, 201U);
  EXPECT_EQ(given.scans, 101U);
  EXPECT_EQ(merger.counts().out_of_order, 0U);
}

TEST_F(SensorMergerDrive, LosesNoScanOrMotionWhereTheClockOfAllSourcesRunsBack) {
  motion_ahead = scan_ahead = fix_ahead = from(1000, -45.0);
  driveToEnd();
  EXPECT_EQ(given.motions, 2000U);
  EXPECT_EQ(given.scans, 1000U);
  EXPECT_EQ(given.resets, 1U);
}

TEST_F(SensorMergerDrive, KeepsTheScansOfTheNewRecordingThatComeBeforeItsMotion) {
  drive(0, 200);
  for (int i = 0; i < 30; ++i) give(detections(10.0 + 0.1 * i));
  for (int i = 0; i < 60; ++i) give(motion(110.0 + 0.05 * i));  // of the old one, late
  EXPECT_EQ(given.resets, 0U);
  for (int i = 0; i < 60; ++i) give(motion(10.0 + 0.05 * i));
  EXPECT_EQ(given.resets, 1U);
  finish();
  EXPECT_EQ(given.scans, 130U);
  EXPECT_EQ(merger.counts().out_of_order, 0U);
}

TEST_F(SensorMergerDrive, BeginsAnewWithMotionAloneWhereScansHaveEnded) {
  drive(0, 200);
  for (int i = 0; i < 200; ++i) give(motion(10.0 + 0.05 * i));
  EXPECT_EQ(given.resets, 1U);
  EXPECT_EQ(merger.counts().out_of_order, 0U);
}

TEST_F(SensorMergerDrive, KeepsTheRecordingWhenOneClockAloneIsPutBack) {
  for (Ahead* ahead : {&motion_ahead, &scan_ahead}) {
    beginAnew();
    motion_ahead = scan_ahead = right;
    *ahead = from(1000, -8.0);
    driveToEnd();
    EXPECT_EQ(given.resets, 0U);
    // 8 s, at 10 Hz, that the filter has used already.
    EXPECT_GE(given.scans, 1000U - 81U);
  }
}

TEST_F(SensorMergerDrive, WaitsForMotionThatGoesOnWhenTheClockOfScansIsAhead) {
  scan_ahead = from(0, 5.0);
  drive(0, 2000);
  EXPECT_EQ(given.scans, 950U);  // those of the last 5 s wait
  EXPECT_EQ(merger.counts().out_of_order, 0U);
  EXPECT_EQ(merger.counts().without_motion, 0U);
}

TEST_F(SensorMergerDrive, TakesUpAScanClockThatIsPutRightAgain) {
  scan_ahead = [](int i) { return i >= 500 && i < 1000 ? 100.0 : 0.0; };
  driveToEnd();
  EXPECT_EQ(given.scans, 750U);
  EXPECT_EQ(given.motions, 2000U);
  EXPECT_EQ(merger.counts().dropped_scans, 250U);
  EXPECT_EQ(given.resets, 0U);
}

TEST_F(SensorMergerDrive, DropsWhatIsNotConfirmedByTheEnd) {
  drive(0, 200);
  give(detections(5000.0));
  finish();
  EXPECT_EQ(given.scans, 100U);
  EXPECT_EQ(merger.counts().dropped_scans, 1U);
}

TEST_F(SensorMergerDrive, KeepsMemoryBoundedWhateverTheClocksSay) {
  scan_ahead = from(0, 1e6);
  fix_ahead = from(0, 1e6);
  drive(0, 12000);
  EXPECT_EQ(given.scans, 0U);
  EXPECT_EQ(merger.counts().dropped_scans, 6000U - 4096U);
  EXPECT_GT(given.motions, 7000U);
}

TEST_F(SensorMergerDrive, UsesScansWithoutMotionWhenNoMoreOfItComesOffline) {
  drive(0, 200);
  is_live = false;
  for (int i = 0; i < 6000; ++i) give(detections(110.0 + 0.1 * i));
  finish();
  EXPECT_EQ(given.scans, 6100U);
  EXPECT_EQ(merger.counts().out_of_order, 0U);
}

TEST_F(SensorMergerDrive, GivesTheSameWhetherAnythingTimesOutOrNot) {
  scan_ahead = [](int i) { return i % 200 == 100 ? 100.0 : i % 200 == 140 ? -30.0 : 0.0; };
  motion_ahead = [](int i) { return i % 300 == 77 ? 50.0 : i % 300 == 177 ? -30.0 : 0.0; };
  fix_ahead = from(0, 5.0);
  driveToEnd();
  const EventTally live = given;
  beginAnew();
  is_live = false;
  driveToEnd();
  EXPECT_EQ(live.motions, given.motions);
  EXPECT_EQ(live.scans, given.scans);
  EXPECT_EQ(live.fixes, given.fixes);
  EXPECT_EQ(live.resets, given.resets);
  EXPECT_EQ(given.motions, 1986U);
  EXPECT_EQ(given.scans, 980U);
}

}  // namespace
}  // namespace hymm::core
