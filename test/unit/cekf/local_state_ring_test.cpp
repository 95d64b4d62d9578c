#include "cekf/local_state_ring.h"

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "cekf/cekf_slam.h"
#include "recorded_loop.h"

namespace hymm::core {
namespace {

TEST(Resumption, TheRingChangesNothing) {
  const Recording recording = record(180);
  CekfSlam with = newSlam(), without = newSlam(0.0);
  feed(with, recording, -1.0, kEnd_s);
  feed(without, recording, -1.0, kEnd_s);
  EXPECT_GT(with.counts().global_updates, 3U);
  EXPECT_LT(difference(jointOf(without), jointOf(with)), 1e-7);
}

/// The filter after all of the recording and back at a scan, and one that ends there.
std::pair<Joint, Joint> backAndThere(const CekfSlamConfig& config, double time_s) {
  const Recording recording = record(180);
  CekfSlam slam = newSlam(kRing_s, config), there = newSlam(kRing_s, config);
  feed(slam, recording, -1.0, kEnd_s);
  feed(there, recording, -1.0, time_s);
  EXPECT_TRUE(slam.suspend(time_s)) << time_s;
  return {jointOf(slam), jointOf(there)};
}

TEST(Resumption, GoesBackToAnyScanOfTheRingToTheBit) {
  CekfSlamConfig one_area = loopConfig();
  one_area.active_area.cell_m = 200.0;
  for (double back_s = 0.5; back_s <= kRing_s - 0.5; back_s += 0.5) {
    const auto [back, there] = backAndThere(one_area, kEnd_s - back_s);
    EXPECT_EQ(back.ids, there.ids);
    EXPECT_TRUE(back.mean == there.mean) << back_s;
    EXPECT_TRUE(back.covariance == there.covariance) << back_s;
  }
}

TEST(Resumption, GoesBackAcrossGlobalUpdates) {
  for (double back_s = 0.5; back_s <= kRing_s - 0.5; back_s += 0.5) {
    const auto [back, there] = backAndThere(loopConfig(), kEnd_s - back_s);
    EXPECT_LT(difference(back, there), 1e-11) << back_s;  // one rounds what it has carried out
  }
}

TEST(Resumption, KeepsTheScansUpToWhereItWaits) {
  const Recording recording = record(180);
  CekfSlam slam = newSlam();
  feed(slam, recording, -1.0, 80.0);
  ASSERT_TRUE(slam.suspend(78.0));
  feed(slam, recording, 80.0, 85.0);
  ASSERT_EQ(slam.localStates()->newest_s, 78.0);
  EXPECT_TRUE(slam.resumeWithoutClosing(slam.localStates()->newest_s).accepted());
  EXPECT_FALSE(slam.isSuspended());
}

TEST(Resumption, KeepsScansForAsLongAsItWasTold) {
  const Recording recording = record(100);
  CekfSlam slam = newSlam();
  EXPECT_FALSE(slam.localStates());
  EXPECT_FALSE(slam.suspend(10.0));
  feed(slam, recording, -1.0, 50.0);
  ASSERT_TRUE(slam.localStates());
  EXPECT_LE(slam.localStates()->oldest_s, 50.0 - kRing_s);
  EXPECT_GE(slam.localStates()->oldest_s, 50.0 - 1.25 * kRing_s - 0.5);
  EXPECT_EQ(slam.localStates()->newest_s, 50.0);
  EXPECT_FALSE(slam.suspend(50.0 - 2.0 * kRing_s));
  EXPECT_FALSE(slam.suspend(49.75));  // no scan
  EXPECT_EQ(slam.counts().forgotten_states, 0U);
  slam.reset();
  EXPECT_FALSE(slam.localStates());
}

/// Of a sensor that is faster, more scans are kept, and no more memories.
TEST(Resumption, KeepsTheSameTimeWhateverTheSensorsRate) {
  const Recording recording = record(100);
  CekfSlam slow = newSlam(), fast = newSlam();
  feed(slow, recording, -1.0, 50.0);
  for (const SensorEvent& event : recording.events) {
    fast.process(event);
    const auto* set = std::get_if<ObservationSet>(&event);
    for (int i = 1; set != nullptr && i < 4; ++i) {  // three more scans after each
      ObservationSet empty;
      empty.time_s = set->time_s + 0.1 * i;
      fast.process(empty);
    }
    if (timeOf(event) >= 50.0 && set != nullptr) break;
  }
  EXPECT_NEAR(fast.localStates()->oldest_s, slow.localStates()->oldest_s, 0.5);
  EXPECT_GT(fast.localStates()->scans, 3 * slow.localStates()->scans);
  EXPECT_TRUE(fast.suspend(50.0 - kRing_s));
}

/// The last scan before a gap can still be gone back to.
TEST(Resumption, KeepsWhatWasBeforeAGap) {
  const Recording recording = record(100);
  CekfSlam slam = newSlam();
  feed(slam, recording, -1.0, 20.0);
  feed(slam, recording, 40.0, 42.0);
  EXPECT_TRUE(slam.suspend(20.0));
}

TEST(Resumption, ReadingTheMapReleasesNothing) {
  const Recording recording = record(180);
  CekfSlam slam = newSlam(), read = newSlam();
  std::size_t updates_pending = 0;
  for (const SensorEvent& event : recording.events) {
    if (timeOf(event) > kEnd_s) break;
    slam.process(event);
    if (!read.process(event)) continue;
    const bool was_pending = read.isGlobalUpdatePending();
    EXPECT_FALSE(read.landmarkMap(30.0).landmarks.empty() && read.landmarkCount() > 0);
    EXPECT_EQ(read.isGlobalUpdatePending(), was_pending);
    updates_pending += was_pending ? 1U : 0U;
  }
  EXPECT_GT(updates_pending, 10U);
  EXPECT_EQ(read.counts().forgotten_states, 0U);
  ASSERT_EQ(read.localStates()->oldest_s, slam.localStates()->oldest_s);
  const double oldest_s = slam.localStates()->oldest_s;
  ASSERT_TRUE(slam.suspend(oldest_s));
  ASSERT_TRUE(read.suspend(oldest_s));
  const Joint a = jointOf(slam), b = jointOf(read);
  EXPECT_EQ(a.ids, b.ids);
  EXPECT_TRUE(a.mean == b.mean);
  EXPECT_TRUE(a.covariance == b.covariance);
}

TEST(Resumption, GivesUpTheOldestScansWhenTheActivePartIsFull) {
  const Recording recording = record(100);
  CekfSlamConfig small = loopConfig();
  small.active_area.max_origin_states = 10;
  CekfSlam slam = newSlam(20.0, small);
  feed(slam, recording, -1.0, 50.0);
  EXPECT_GT(slam.counts().forgotten_states, 0U);
  ASSERT_TRUE(slam.localStates());
  EXPECT_FALSE(slam.suspend(slam.localStates()->oldest_s - 0.5));
  EXPECT_TRUE(slam.suspend(slam.localStates()->oldest_s));
}

}  // namespace
}  // namespace hymm::core
