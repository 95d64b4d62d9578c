#include "pipeline/latency_histogram.h"

#include <limits>

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

TEST(LatencyHistogram, QuantilesAreRightToHalfAPercent) {
  LatencyHistogram histogram;
  for (int i = 1; i <= 1000; ++i) histogram.add(0.01 * i);
  EXPECT_NEAR(histogram.quantile(0.5), 5.0, 0.005 * 5.0);
  EXPECT_NEAR(histogram.quantile(0.95), 9.5, 0.005 * 9.5);
  EXPECT_NEAR(histogram.quantile(0.999), 9.99, 0.005 * 9.99);
  EXPECT_EQ(histogram.max(), 10.0);
}

TEST(LatencyHistogram, NoQuantileExceedsTheMaximum) {
  LatencyHistogram histogram;
  histogram.add(2.0);
  EXPECT_EQ(histogram.quantile(0.5), 2.0);
  EXPECT_EQ(histogram.quantile(0.999), 2.0);
}

TEST(LatencyHistogram, HoldsTimesBeyondItsRange) {
  LatencyHistogram histogram;
  histogram.add(0.0);
  histogram.add(1e9);
  histogram.add(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(histogram.count(), 2u);
  EXPECT_EQ(histogram.max(), 1e9);
  EXPECT_LE(histogram.quantile(0.5), 1e-3);
}

TEST(LatencyHistogram, IsZeroWithoutTimes) { EXPECT_EQ(LatencyHistogram().quantile(0.5), 0.0); }

}  // namespace
}  // namespace hymm::core
