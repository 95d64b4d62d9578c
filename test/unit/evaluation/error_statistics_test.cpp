#include "evaluation/error_statistics.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

TEST(ErrorStatistics, OfKnownErrors) {
  const ErrorStatistics statistics = errorStatistics({4.0, 1.0, 3.0, 2.0});
  EXPECT_EQ(statistics.count, 4u);
  EXPECT_DOUBLE_EQ(statistics.rmse, std::sqrt(7.5));
  EXPECT_DOUBLE_EQ(statistics.median, 2.5);
  EXPECT_DOUBLE_EQ(statistics.max, 4.0);
  EXPECT_DOUBLE_EQ(errorStatistics({5.0, 1.0, 2.0}).median, 2.0);
  EXPECT_EQ(errorStatistics({}).count, 0u);
}

TEST(ConsistencySum, SharesAndMeans) {
  ConsistencySum sum;
  sum.add(2.0, 2);   // within [0.05, 7.38]
  sum.add(20.0, 2);  // above
  sum.add(0.01, 2);  // below
  sum.add(4.0, 4);   // within [0.48, 11.14]
  sum.add(99.0, 0);  // no degrees of freedom: not counted
  sum.add(std::numeric_limits<double>::quiet_NaN(), 2);
  const Consistency result = sum.result();
  EXPECT_EQ(result.count, 4u);
  EXPECT_DOUBLE_EQ(result.share_in_band, 0.5);
  EXPECT_DOUBLE_EQ(result.mean, 26.01 / 4.0);
  EXPECT_DOUBLE_EQ(result.mean_per_dof, 2.601);
}

}  // namespace
}  // namespace hymm::core
