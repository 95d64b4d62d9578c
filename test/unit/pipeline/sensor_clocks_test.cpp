#include <functional>
#include <limits>
#include <tuple>

#include <gtest/gtest.h>

#include "pipeline/sensor_merger.h"
#include "support/sensor_events.h"

namespace hymm::core {
namespace {

constexpr double kForever = std::numeric_limits<double>::infinity();

SensorEvent fixAt(double time_s) {
  GpsFix fix;
  fix.time_s = time_s;
  return fix;
}

/// A drive with motion at 20 Hz, scans at 10 Hz and fixes at 1 Hz, in steps of 50 ms.
class SensorMergerDrive : public testing::Test {
 protected:
  static constexpr double kStep_s = 0.05;

  /// Steps from `first` on; each stamp is changed by its source's function.
  void drive(int first, int steps) {
    for (int i = first; i < first + steps; ++i) {
      const double time_s = 100.0 + kStep_s * i;
      if (motion_ahead) give(motion(time_s + motion_ahead(i)));
      if (scan_ahead && i % 2 == 0) give(detections(time_s - 0.01 + scan_ahead(i)));
      if (i % 20 == 0) give(fixAt(time_s + fix_ahead(i)));
    }
  }
  void give(SensorEvent event) {
    merger.push(std::move(event), now_s += 0.01);
    take(merger.popReady(now_s));
  }
  void finish() { take(merger.flush()); }

  void take(const std::vector<SensorEvent>& events) {
    for (const SensorEvent& event : events) {
      if (std::holds_alternative<ClockReset>(event)) {
        ++resets;
        last_s = -kForever;
        continue;
      }
      EXPECT_GE(timeOf(event), last_s);
      last_s = timeOf(event);
      if (std::holds_alternative<MotionInput>(event)) ++motions;
      if (std::holds_alternative<ObservationSet>(event)) ++scans;
      if (std::holds_alternative<GpsFix>(event)) ++fixes;
    }
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
  double now_s = 0.0, last_s = -kForever;
  std::size_t motions = 0, scans = 0, fixes = 0, resets = 0;
};

TEST_F(SensorMergerDrive, UsesEverythingThatIsInOrder) {
  drive(0, 2000);
  finish();
  EXPECT_EQ(motions, 2000U);
  EXPECT_EQ(scans, 1000U);
  EXPECT_EQ(fixes, 100U);
  EXPECT_EQ(merger.counts().out_of_order, 0U);
  EXPECT_EQ(merger.counts().without_motion, 0U);
}

TEST_F(SensorMergerDrive, UsesAllScansAndMotionWhenTheGpsClockIsAhead) {
  for (const double by_s : {0.7, 5.0, 3600.0}) {
    SCOPED_TRACE(by_s);
    merger = SensorMerger({});
    motions = scans = fixes = 0;
    last_s = -kForever;
    fix_ahead = from(0, by_s);
    drive(0, 2000);
    EXPECT_EQ(scans, 1000U);
    finish();
    EXPECT_EQ(motions, 2000U);
    EXPECT_EQ(scans, 1000U);
    EXPECT_EQ(merger.counts().dropped_scans, 0U);
    EXPECT_EQ(fixes + merger.counts().out_of_order, 100U);
  }
}

TEST_F(SensorMergerDrive, UsesFixesOfAClockThatIsAheadAtTheirStamps) {
  fix_ahead = from(0, 5.0);
  drive(0, 2000);
  EXPECT_EQ(fixes, 95U);
}

TEST_F(SensorMergerDrive, UsesAllScansAndMotionWhenTheGpsClockIsPutBack) {
  fix_ahead = from(1000, -20.0);
  drive(0, 2000);
  finish();
  EXPECT_EQ(motions, 2000U);
  EXPECT_EQ(scans, 1000U);
  EXPECT_EQ(resets, 0U);
}

TEST_F(SensorMergerDrive, AStrayFixDelaysNothing) {
  fix_ahead = once(500, 100.0);
  drive(0, 2000);
  finish();
  EXPECT_EQ(scans, 1000U);
  EXPECT_EQ(fixes, 99U);
}

TEST_F(SensorMergerDrive, DropsOneScanFarAheadAndNothingElse) {
  scan_ahead = once(1000, 100.0);
  drive(0, 2000);
  finish();
  EXPECT_EQ(motions, 2000U);
  EXPECT_EQ(scans, 999U);
  EXPECT_EQ(fixes, 100U);
  EXPECT_EQ(resets, 0U);
  EXPECT_EQ(merger.counts().out_of_order, 1U);
  EXPECT_EQ(merger.counts().dropped_scans, 1U);
}

TEST_F(SensorMergerDrive, DropsOneMotionInputFarAheadAndNothingElse) {
  motion_ahead = once(1001, 100.0);
  drive(0, 2000);
  finish();
  EXPECT_EQ(motions, 1999U);
  EXPECT_EQ(scans, 1000U);
  EXPECT_EQ(resets, 0U);
  EXPECT_EQ(merger.counts().out_of_order, 1U);
  EXPECT_EQ(merger.counts().dropped_scans, 0U);
}

TEST_F(SensorMergerDrive, RecoversFromAFirstStampThatIsStray) {
  for (Ahead* ahead : {&motion_ahead, &scan_ahead}) {
    merger = SensorMerger({});
    motions = scans = 0;
    last_s = -kForever;
    motion_ahead = scan_ahead = right;
    *ahead = once(0, 100.0);
    drive(0, 2000);
    finish();
    EXPECT_EQ(motions + scans + merger.counts().out_of_order, 3000U);
    EXPECT_LE(merger.counts().out_of_order, 3U);
    EXPECT_EQ(resets, 0U);
  }
}

TEST_F(SensorMergerDrive, LosesNothingToAGapThatAllSourcesShare) {
  motion_ahead = scan_ahead = fix_ahead = from(1000, 3600.0);
  drive(0, 2000);
  finish();
  EXPECT_EQ(motions, 2000U);
  EXPECT_EQ(scans, 1000U);
  EXPECT_EQ(fixes, 100U);
  EXPECT_EQ(resets, 0U);
  EXPECT_EQ(merger.counts().without_motion, 0U);
}

TEST_F(SensorMergerDrive, BelievesAGapOnceMotionAndScansTogetherAgree) {
  drive(0, 200);
  give(motion(115.0));
  give(detections(115.0));
  EXPECT_EQ(scans, 100U);
  give(motion(115.05));
  EXPECT_EQ(motions, 201U);
  EXPECT_EQ(scans, 101U);
  EXPECT_EQ(merger.counts().out_of_order, 0U);
}

TEST_F(SensorMergerDrive, LosesNoScanOrMotionWhereTheClockOfAllSourcesRunsBack) {
  motion_ahead = scan_ahead = fix_ahead = from(1000, -45.0);
  drive(0, 2000);
  finish();
  EXPECT_EQ(motions, 2000U);
  EXPECT_EQ(scans, 1000U);
  EXPECT_EQ(resets, 1U);
}

TEST_F(SensorMergerDrive, KeepsTheScansOfTheNewRecordingThatComeBeforeItsMotion) {
  drive(0, 200);
  for (int i = 0; i < 30; ++i) give(detections(10.0 + 0.1 * i));
  for (int i = 0; i < 60; ++i) give(motion(110.0 + 0.05 * i));  // of the old one, late
  EXPECT_EQ(resets, 0U);
  for (int i = 0; i < 60; ++i) give(motion(10.0 + 0.05 * i));
  EXPECT_EQ(resets, 1U);
  finish();
  EXPECT_EQ(scans, 130U);
  EXPECT_EQ(merger.counts().out_of_order, 0U);
}

TEST_F(SensorMergerDrive, BeginsAnewWithMotionAloneWhereScansHaveEnded) {
  drive(0, 200);
  for (int i = 0; i < 200; ++i) give(motion(10.0 + 0.05 * i));
  EXPECT_EQ(resets, 1U);
  EXPECT_EQ(merger.counts().out_of_order, 0U);
}

TEST_F(SensorMergerDrive, KeepsTheRecordingWhenOneClockAloneIsPutBack) {
  for (Ahead* ahead : {&motion_ahead, &scan_ahead}) {
    merger = SensorMerger({});
    scans = 0;
    last_s = -kForever;
    motion_ahead = scan_ahead = right;
    *ahead = from(1000, -8.0);
    drive(0, 2000);
    finish();
    EXPECT_EQ(resets, 0U);
    // 8 s, at 10 Hz, that the filter has used already.
    EXPECT_GE(scans, 1000U - 81U);
  }
}

TEST_F(SensorMergerDrive, WaitsForMotionThatGoesOnWhenTheClockOfScansIsAhead) {
  scan_ahead = from(0, 5.0);
  drive(0, 2000);
  EXPECT_EQ(scans, 950U);  // those of the last 5 s wait
  EXPECT_EQ(merger.counts().out_of_order, 0U);
  EXPECT_EQ(merger.counts().without_motion, 0U);
}

TEST_F(SensorMergerDrive, TakesUpAScanClockThatIsPutRightAgain) {
  scan_ahead = [](int i) { return i >= 500 && i < 1000 ? 100.0 : 0.0; };
  drive(0, 2000);
  finish();
  EXPECT_EQ(scans, 750U);
  EXPECT_EQ(motions, 2000U);
  EXPECT_EQ(merger.counts().dropped_scans, 250U);
  EXPECT_EQ(resets, 0U);
}

TEST_F(SensorMergerDrive, DropsWhatIsNotConfirmedByTheEnd) {
  drive(0, 200);
  give(detections(5000.0));
  finish();
  EXPECT_EQ(scans, 100U);
  EXPECT_EQ(merger.counts().dropped_scans, 1U);
}

TEST_F(SensorMergerDrive, KeepsMemoryBoundedWhateverTheClocksSay) {
  scan_ahead = from(0, 1e6);
  fix_ahead = from(0, 1e6);
  drive(0, 12000);
  EXPECT_EQ(scans, 0U);
  EXPECT_EQ(merger.counts().dropped_scans, 6000U - 4096U);
  EXPECT_GT(motions, 7000U);
}

TEST_F(SensorMergerDrive, UsesScansWithoutMotionWhenNoMoreOfItComesOffline) {
  drive(0, 200);
  std::size_t in = 0;
  for (int i = 0; i < 6000; ++i, ++in) {
    merger.push(detections(110.0 + 0.1 * i));
    take(merger.popReady());
  }
  finish();
  EXPECT_EQ(scans, 100U + in);
  EXPECT_EQ(merger.counts().out_of_order, 0U);
}

TEST_F(SensorMergerDrive, GivesTheSameWhetherAnythingTimesOutOrNot) {
  scan_ahead = [](int i) { return i % 200 == 100 ? 100.0 : i % 200 == 140 ? -30.0 : 0.0; };
  motion_ahead = [](int i) { return i % 300 == 77 ? 50.0 : i % 300 == 177 ? -30.0 : 0.0; };
  fix_ahead = from(0, 5.0);
  drive(0, 2000);
  finish();
  const auto live = std::make_tuple(motions, scans, fixes, resets);
  motions = scans = fixes = resets = 0;
  last_s = -kForever;
  SensorMerger offline({});
  for (int i = 0; i < 2000; ++i) {
    const double time_s = 100.0 + kStep_s * i;
    offline.push(motion(time_s + motion_ahead(i)));
    if (i % 2 == 0) offline.push(detections(time_s - 0.01 + scan_ahead(i)));
    if (i % 20 == 0) offline.push(fixAt(time_s + fix_ahead(i)));
    take(offline.popReady());
  }
  take(offline.flush());
  EXPECT_EQ(live, std::make_tuple(motions, scans, fixes, resets));
  EXPECT_EQ(motions, 1986U);
  EXPECT_EQ(scans, 980U);
}

}  // namespace
}  // namespace hymm::core
