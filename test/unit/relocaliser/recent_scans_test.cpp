#include "relocaliser/recent_scans.h"

#include <gtest/gtest.h>

#include "relocaliser/convergence.h"

namespace hymm::core {
namespace {

constexpr double kDuration_s = 2.0;

/// What is kept of a long drive past one landmark, by a sensor of that rate.
RecentScans keptOf(double rate_hz) {
  RecentScans scans(kDuration_s);
  const Pose2 step{4.0 / rate_hz, 0.0, 0.0};
  for (int i = 0; i < 10.0 * rate_hz; ++i) {
    scans.move(step, Eigen::Matrix3d::Zero());
    scans.add(i / rate_hz, {{Eigen::Vector2f(10.0F, 5.0F), 0.1, 10.0}});
  }
  return scans;
}

TEST(RecentScans, AreTenOfTwoSecondsAtFiveHertz) { EXPECT_EQ(keptOf(5.0).size(), 10U); }

TEST(RecentScans, OfAFasterSensorAreHardlyMoreAndSpreadOverTheSameTime) {
  for (const double rate_hz : {10.0, 20.0, 40.0, 75.0}) {
    const RecentScans scans = keptOf(rate_hz);
    EXPECT_GE(scans.size(), 9U) << rate_hz;
    EXPECT_LE(scans.size(), 11U) << rate_hz;
    // The vehicle drives 4 m/s: the oldest point lies nearly 8 m behind the newest.
    const std::vector<ObservedPoint> points = scans.points();
    EXPECT_EQ(points.back().p_base_point.x(), 10.0F);
    EXPECT_NEAR(points.front().p_base_point.x(), 10.0F - 8.0F, 1.0F) << rate_hz;
  }
}

TEST(RecentScans, OfASlowSensorAreSeveralAllTheSame) {
  EXPECT_EQ(keptOf(1.0).size(), RecentScans::kFewest);
}

Explanation of(const std::vector<int>& seen, const std::vector<int>& missed) {
  Explanation explanation;
  explanation.observations = static_cast<int>(seen.size());
  explanation.explained = explanation.observations;
  explanation.seen = seen;
  explanation.missed = missed;
  return explanation;
}

/// Time after which nothing speaks against a place any more, at 10 m/s.
double heldFor(double rate_hz) {
  const ConvergenceConfig config;
  HeldEvidence held(config.holdSpacing_s());
  for (int i = 0; i < 100.0 * rate_hz; ++i) {
    held.add(i / rate_hz, of({1, 2, 3}, {}), 10.0 / rate_hz);
    if (findDoubt(held, config).empty()) return i / rate_hz;
  }
  return 100.0;
}

TEST(HeldEvidence, HasToLastForTheSameTimeWhateverTheSensorsRate) {
  const ConvergenceConfig config;
  for (const double rate_hz : {5.0, 10.0, 20.0, 40.0, 75.0}) {
    EXPECT_NEAR(heldFor(rate_hz), config.hold_s, 1.0 / rate_hz) << rate_hz;
  }
}

TEST(HeldEvidence, TakesThreeScansOfASlowSensor) { EXPECT_EQ(heldFor(1.0), 2.0); }

TEST(HeldEvidence, ALandmarkIsNotAbsentBecauseAFastSensorMissedItForAMoment) {
  HeldEvidence held(0.2);
  for (int i = 0; i < 10; ++i) held.add(0.013 * i, of({1, 2, 3}, {4}), 0.1);
  EXPECT_EQ(held.absent(), 0);
  for (int i = 10; i < 60; ++i) held.add(0.013 * i, of({1, 2, 3}, {4}), 0.1);
  EXPECT_EQ(held.absent(), 1);
}

}  // namespace
}  // namespace hymm::core
