#include "pipeline/sensor_merger.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/sensor_events.h"

namespace hymm::core {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr double kForever = std::numeric_limits<double>::infinity();

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

/// Whose vehicle does what it is told 0.2 s later.
SensorMerger delayedMerger() {
  SensorMergerConfig config;
  config.motion_delay_s = 0.2;
  return SensorMerger(config);
}

TEST(SensorMerger, LetsMotionCountWhenTheVehicleDoesIt) {
  SensorMerger merger = delayedMerger();
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
  EventTally given;
  for (int i = 0; i < 20; ++i) {
    merger.push(detections(1.05 + 0.2 * i));
    given.take(merger.popReady());
  }
  EXPECT_EQ(given.scans, 20U);
  EXPECT_EQ(merger.counts().clock_resets, 0U);
}

/// What was measured from `begin_s` to `end_s`, as by two poses.
SensorEvent motionBetween(double begin_s, double end_s) {
  return MotionInput{TwistInput{begin_s, 1.0, 0.0, 0.0, std::nullopt, end_s}};
}

TEST(SensorMerger, AMeanReleasesAScanAtItsEnd) {
  SensorMerger merger({});
  merger.push(motionBetween(1.0, 1.1));
  merger.push(detections(1.15));
  EXPECT_THAT(signature(merger.popReady()), IsEmpty());
  merger.push(motionBetween(1.1, 1.2));
  EXPECT_THAT(signature(merger.popReady()), ElementsAre(1.0, 1.1, -1.15));
  EXPECT_EQ(merger.counts().without_motion, 0U);
}

TEST(SensorMerger, AMeanThatBeginsWithAScanComesBehindItWhicheverArrivesFirst) {
  for (const bool scan_is_late : {false, true}) {
    SensorMerger merger({});
    merger.push(motionBetween(1.0, 1.1));
    if (!scan_is_late) merger.push(detections(1.1));
    std::vector<SensorEvent> events = merger.popReady();
    merger.push(motionBetween(1.1, 1.2));
    if (scan_is_late) merger.push(detections(1.1));
    for (SensorEvent& event : merger.flush()) events.push_back(std::move(event));
    EXPECT_THAT(signature(events), ElementsAre(1.0, -1.1, 1.1)) << scan_is_late;
  }
}

TEST(SensorMerger, OfAMeanThatComesTooLateTheRestCounts) {
  SensorMerger merger({});
  merger.push(motionBetween(1.0, 1.2), 10.0);
  merger.push(detections(1.3), 10.0);
  EXPECT_THAT(signature(merger.popReady(10.2)), ElementsAre(1.0, -1.3));
  merger.push(motionBetween(1.2, 1.4), 10.3);
  merger.push(detections(1.35), 10.3);
  EXPECT_THAT(signature(merger.popReady(10.3)), ElementsAre(1.3, -1.35));
  EXPECT_EQ(merger.counts().out_of_order, 0U);
}

TEST(SensorMerger, AMeanThatIsOverIsDroppedAndCounted) {
  SensorMerger merger({});
  merger.push(motionBetween(1.0, 1.1), 10.0);
  merger.push(detections(1.2), 10.0);
  EXPECT_THAT(signature(merger.popReady(10.2)), ElementsAre(1.0, -1.2));
  merger.push(motionBetween(1.1, 1.2), 10.3);
  merger.push(motionBetween(1.2, 1.3), 10.3);
  EXPECT_THAT(signature(merger.flush()), ElementsAre(1.2));
  EXPECT_EQ(merger.counts().out_of_order, 1U);
}

TEST(SensorMerger, AMeanUpToAStampThatNobodyConfirmsIsStray) {
  SensorMerger merger({});
  merger.push(motionBetween(1.0, 1.1));
  merger.push(motionBetween(1.1, 1000.0));
  merger.push(motionBetween(1.2, 1.3));
  merger.push(detections(1.25));
  EXPECT_THAT(signature(merger.popReady()), ElementsAre(1.0, 1.2, -1.25));
  EXPECT_EQ(merger.counts().out_of_order, 1U);
}

TEST(SensorMerger, MeansAreDelayedAtBothEnds) {
  SensorMerger merger = delayedMerger();
  merger.push(motionBetween(1.0, 1.1));
  merger.push(detections(1.25));
  EXPECT_THAT(signature(merger.popReady()), ElementsAre(1.2, -1.25));
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
