#include "supervisor/loss_test.h"

#include <algorithm>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "common/random.h"
#include "supervisor/suspicion.h"

namespace hymm::core {
namespace {

constexpr double kPeriod_s = 0.2;
constexpr double kNever_s = std::numeric_limits<double>::infinity();

ScanEvidence scanWith(int expected, int missed, double unexplained = 0.0) {
  ScanEvidence scan;
  scan.confirmed_expected = expected;
  scan.confirmed_missed = missed;
  scan.unexplained = unexplained;
  return scan;
}

/// Time of the first alarm over scans that `see` makes, or kNever_s.
double alarmAfter_s(const std::function<ScanEvidence(double)>& see, double duration_s,
                    double period_s = kPeriod_s, const LossTestConfig& config = {}) {
  LossTest test;
  for (double time_s = 0.0; time_s <= duration_s; time_s += period_s) {
    test = test.after(time_s, see(time_s), duration_s, config);
    if (test.alarms(config)) return time_s;
  }
  return kNever_s;
}

TEST(LossTest, AlarmsSoonWhereAllLandmarksInClearViewAreMissed) {
  const auto missing = [](double) { return scanWith(4, 4, 1.0); };
  EXPECT_LT(alarmAfter_s(missing, 60.0), 2.5);
}

TEST(LossTest, TakesTheSameTimeWhateverTheSensorsRate) {
  const auto missing = [](double) { return scanWith(4, 4, 1.0); };
  for (const double period_s : {0.025, 0.1, 0.5}) {
    EXPECT_NEAR(alarmAfter_s(missing, 60.0, period_s), 1.8, 0.2 + period_s) << period_s;
  }
}

TEST(LossTest, CountsAGapAsOneScan) {
  const auto missing = [](double) { return scanWith(4, 4, 1.0); };
  EXPECT_EQ(alarmAfter_s(missing, 1000.0, 100.0), 200.0);  // as if they were 1 s apart
}

TEST(LossTest, NeverDoubtsOnNewGround) {
  EXPECT_EQ(alarmAfter_s([](double) { return scanWith(0, 0, 1.0); }, 1000.0), kNever_s);
}

TEST(LossTest, NeverDoubtsWhileMostLandmarksAreSeen) {
  EXPECT_EQ(alarmAfter_s([](double) { return scanWith(5, 2, 0.9); }, 10000.0), kNever_s);
}

/// A lost filter drops the landmarks that it misses, and then nothing is left to be missed.
TEST(LossTest, GoesOnDoubtingWhenTheLandmarksAreDropped) {
  const auto dropping = [](double time_s) {
    return time_s < 0.7 ? scanWith(4, 4, 1.0) : scanWith(0, 0, 1.0);
  };
  EXPECT_LT(alarmAfter_s(dropping, 60.0), 15.0);
  const auto explained = [](double time_s) {
    return time_s < 0.7 ? scanWith(4, 4, 1.0) : scanWith(0, 0, 0.2);
  };
  EXPECT_EQ(alarmAfter_s(explained, 60.0), kNever_s);
}

TEST(LossTest, OneScanInGoodOrderAfterAnotherEndsTheDoubt) {
  LossTest test;
  const LossTestConfig config;
  double time_s = 0.0;
  const auto take = [&](const ScanEvidence& scan) {
    test = test.after(time_s, scan, 15.0, config);
    time_s += kPeriod_s;
  };
  take(scanWith(4, 0));
  take(scanWith(4, 4));
  EXPECT_TRUE(test.doubts());
  take(scanWith(4, 0));
  EXPECT_FALSE(test.doubts());
}

TEST(LossTest, DropsDoubtThatComesToNothing) {
  LossTest test;
  const LossTestConfig config;
  test = test.after(0.0, scanWith(4, 0), 15.0, config);
  test = test.after(0.2, scanWith(4, 4, 1.0), 15.0, config);
  for (double time_s = 0.4; time_s < 14.9; time_s += 0.2) {
    test = test.after(time_s, scanWith(0, 0), 15.0, config);
    EXPECT_TRUE(test.doubts());
  }
  test = test.after(15.3, scanWith(0, 0), 15.0, config);
  EXPECT_FALSE(test.doubts());
}

/// At the worst rates that count as good order, each miss lasting for `independent_s`: the case
/// that the interval is stated for. The bound on the mean holds with room.
TEST(LossTest, KeepsItsIntervalBetweenFalseAlarmsWhereMissesLast) {
  LossTestConfig config;
  config.false_alarm_interval_h = 0.02;  // 72 s
  RandomGenerator generator(7);
  const int runs = 200;
  double total_s = 0.0;
  for (int run = 0; run < runs; ++run) {
    ScanEvidence scan;
    int block = -1;
    const auto see = [&](double time_s) {
      if (const int now = static_cast<int>(time_s / config.independent_s); now != block) {
        block = now;
        scan = scanWith(4, 0);
        for (int i = 0; i < 4; ++i) {
          scan.confirmed_missed += sampleUniform(generator, 0.0, 1.0) > config.seen_share ? 1 : 0;
        }
      }
      return scan;
    };
    total_s += std::min(alarmAfter_s(see, 5000.0, kPeriod_s, config), 5000.0);
  }
  EXPECT_GT(total_s / runs, 3600.0 * config.false_alarm_interval_h);
}

}  // namespace
}  // namespace hymm::core
