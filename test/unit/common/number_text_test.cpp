#include "common/number_text.h"

#include <cmath>
#include <cstdlib>
#include <limits>

#include <gtest/gtest.h>

#include "common/random.h"

namespace hymm::core {
namespace {

TEST(NumberText, ReadsBackAsTheSameDouble) {
  RandomGenerator generator(1);
  for (int i = 0; i < 10000; ++i) {
    const double value =
        sampleNormal(generator, 1.0) * std::pow(10.0, sampleUniform(generator, -300, 300));
    ASSERT_EQ(std::strtod(numberText(value).c_str(), nullptr), value) << numberText(value);
  }
}

TEST(NumberText, IsShort) {
  EXPECT_EQ(numberText(0.1), "0.1");
  EXPECT_EQ(numberText(1545.2), "1545.2");
  EXPECT_EQ(numberText(3.0), "3");
}

TEST(NumberText, WritesNonFiniteValuesAsWords) {
  EXPECT_EQ(numberText(std::numeric_limits<double>::quiet_NaN()), "nan");
  EXPECT_EQ(numberText(-std::numeric_limits<double>::quiet_NaN()), "nan");
  EXPECT_EQ(numberText(std::numeric_limits<double>::infinity()), "inf");
  EXPECT_EQ(numberText(-std::numeric_limits<double>::infinity()), "-inf");
}

}  // namespace
}  // namespace hymm::core
