#include "pipeline/sensor_merger.h"

#include <functional>
#include <limits>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hymm::core {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr double kForever = std::numeric_limits<double>::infinity();

SensorEvent motion(double time_s) { return MotionInput{TwistInput{time_s, 1.0, 0.0, 0.0}}; }

SensorEvent detections(double time_s) {
  ObservationSet set;
  set.time_s = time_s;
  return set;
}

/// Times of events: positive for motion, negative for measurements, 1e6 for a clock reset.
std::vector<double> signature(const std::vector<SensorEvent>& events) {
  std::vector<double> times;
  for (const SensorEvent& event : events) {
    if (std::holds_alternative<ClockReset>(event)) {
      times.push_back(1e6);
    } else {
      times.push_back(std::holds_alternative<MotionInput>(event) ? timeOf(event) : -timeOf(event));
    }
  }
  return times;
}

TEST(SensorMerger, HoldsAScanUntilMotionPastItsStampHasCome) {
  SensorMerger merger({});
  merger.push(motion(1.0));
  merger.push(detections(1.05));
  EXPECT_THAT(signature(merger.popReady()), IsEmpty());
  merger.push(motion(1.1));
  EXPECT_THAT(signature(merger.popReady()), ElementsAre(1.0, -1.05));
}

TEST(SensorMerger, SortsByStampWhateverTheOrderOfArrival) {
  SensorMerger merger({});
  for (const double t : {1.2, 1.0, 1.1}) merger.push(motion(t));
  merger.push(detections(1.15));
  merger.push(detections(1.05));
  EXPECT_THAT(signature(merger.popReady()), ElementsAre(1.0, -1.05, 1.1, -1.15));
}

TEST(SensorMerger, LetsMotionCountWhenTheVehicleDoesIt) {
  SensorMergerConfig config;
  config.motion_delay_s = 0.2;
  SensorMerger merger(config);
  merger.push(motion(1.0));
  merger.push(detections(1.1));  // until 1.2 the vehicle does not do what it was told at 1.0
  EXPECT_THAT(signature(merger.popReady()), ElementsAre(-1.1));
  merger.push(motion(1.1));
  merger.push(detections(1.25));
  EXPECT_THAT(signature(merger.popReady()), ElementsAre(1.2, -1.25));
}

TEST(SensorMerger, ReleasesAScanWithoutMotionAfterItsWait) {
  SensorMerger merger({});
  merger.push(motion(1.0), 10.0);
  merger.push(detections(1.05), 10.0);
  EXPECT_THAT(signature(merger.popReady(10.09)), IsEmpty());
  EXPECT_THAT(signature(merger.popReady(10.11)), ElementsAre(1.0, -1.05));
  EXPECT_EQ(merger.counts().without_motion, 1U);
}

TEST(SensorMerger, DropsAndCountsWhatComesTooLate) {
  SensorMerger merger({});
  merger.push(motion(1.0));
  merger.push(detections(1.05));
  merger.push(motion(1.1));
  EXPECT_EQ(merger.popReady().size(), 2U);
  merger.push(detections(1.01));
  merger.push(motion(1.02));
  EXPECT_THAT(signature(merger.popReady(kForever)), IsEmpty());
  EXPECT_EQ(merger.counts().out_of_order, 2U);
}

TEST(SensorMerger, TakesARunOfOldEventsForANewRecording) {
  SensorMerger merger({});
  merger.push(motion(100.0));
  merger.push(detections(100.1));
  for (const double t : {1.0, 1.1, 1.2}) merger.push(motion(t));
  merger.push(detections(1.15));
  EXPECT_THAT(signature(merger.popReady()), ElementsAre(100.0, -100.1, 1e6, 1.0, 1.1, -1.15));
  EXPECT_EQ(merger.counts().clock_resets, 1U);
}

TEST(SensorMerger, DoesNotTakeStrayOldEventsForANewRecording) {
  SensorMerger merger({});
  merger.push(motion(100.0));
  merger.push(detections(100.0));
  EXPECT_THAT(signature(merger.popReady()), ElementsAre(100.0, -100.0));
  for (int i = 0; i < 10; ++i) {
    merger.push(detections(50.0 + i));
    merger.push(motion(100.1 + 0.1 * i));
  }
  EXPECT_THAT(signature(merger.popReady()), IsEmpty());
  EXPECT_EQ(merger.counts().clock_resets, 0U);
  EXPECT_EQ(merger.counts().out_of_order, 10U);
}

TEST(SensorMerger, DoesNotTakeALateTopicForANewRecording) {
  SensorMerger merger({});
  for (int i = 0; i < 100; ++i) merger.push(motion(1.0 + 0.1 * i));
  std::size_t scans = 0;
  for (int i = 0; i < 20; ++i) {
    merger.push(detections(1.05 + 0.2 * i));
    for (const SensorEvent& event : merger.popReady()) {
      scans += std::holds_alternative<ObservationSet>(event) ? 1U : 0U;
    }
  }
  EXPECT_EQ(scans, 20U);
  EXPECT_EQ(merger.counts().clock_resets, 0U);
}

TEST(SensorMerger, EmptiesItselfAtTheEnd) {
  SensorMerger merger({});
  merger.push(motion(1.0));
  merger.push(detections(2.0));
  merger.push(motion(1.5));
  EXPECT_THAT(signature(merger.flush()), ElementsAre(1.0, 1.5, -2.0));
  EXPECT_THAT(signature(merger.flush()), IsEmpty());
}

TEST(SensorMerger, KeepsMemoryBoundedWithoutMeasurements) {
  SensorMerger merger({});
  std::size_t released = 0;
  for (int i = 0; i < 10000; ++i) {
    merger.push(motion(0.025 * i));
    released += merger.popReady().size();
  }
  EXPECT_GT(released, 5000U);
  merger.push(detections(0.025 * 9999.0));
  EXPECT_EQ(released + merger.popReady().size(), 10001U);
}

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

/// 101 beams, a millisecond apart.
SensorEvent rotatingScan(double time_s) {
  ScanEvent event;
  event.scan.time_s = time_s;
  event.scan.time_increment_s = 0.001;
  event.scan.ranges_m.assign(101, 5.0F);
  return event;
}

std::vector<double> motionMeanwhile(const SensorEvent& event) {
  std::vector<double> times;
  for (const MotionInput& input : std::get<ScanEvent>(event).motion_meanwhile) {
    times.push_back(timeOf(input));
  }
  return times;
}

TEST(SensorMerger, HoldsAScanThatTakesItsTimeUntilMotionPastItsLastBeamHasCome) {
  SensorMerger merger({});
  merger.push(motion(1.0));
  merger.push(rotatingScan(1.02));
  for (const double t : {1.05, 1.10}) merger.push(motion(t));
  EXPECT_THAT(signature(merger.popReady()), IsEmpty());
  merger.push(motion(1.15));
  const std::vector<SensorEvent> ready = merger.popReady();
  EXPECT_THAT(signature(ready), ElementsAre(1.0, -1.02));
  EXPECT_THAT(motionMeanwhile(ready.back()), ElementsAre(1.05, 1.10));
  merger.push(detections(1.11));
  EXPECT_THAT(signature(merger.popReady()), ElementsAre(1.05, 1.10, -1.11));
}

TEST(SensorMerger, TellsAScanWhatMotionCameWhenItHasWaitedLongEnough) {
  SensorMerger merger({});
  for (const double t : {1.0, 1.05}) merger.push(motion(t), 10.0);
  merger.push(rotatingScan(1.02), 10.0);
  EXPECT_THAT(signature(merger.popReady(10.09)), IsEmpty());
  const std::vector<SensorEvent> ready = merger.popReady(10.11);
  EXPECT_THAT(signature(ready), ElementsAre(1.0, -1.02));
  EXPECT_THAT(motionMeanwhile(ready.back()), ElementsAre(1.05));
  EXPECT_EQ(merger.counts().without_motion, 1U);
}

}  // namespace
}  // namespace hymm::core
