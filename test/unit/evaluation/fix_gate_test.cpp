#include "evaluation/fix_gate.h"

#include <limits>

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

TEST(FixGate, LeavesOutAJumpAndGoesOnFromTheLastKeptFix) {
  FixGate gate;
  EXPECT_TRUE(gate.keep(0.0, {0.0, 0.0}));
  EXPECT_TRUE(gate.keep(1.0, {5.0, 0.0}));
  EXPECT_FALSE(gate.keep(2.0, {40.0, 0.0}));
  EXPECT_TRUE(gate.keep(3.0, {15.0, 0.0}));
}

TEST(FixGate, FifteenMetresPerSecondIsStillKept) {
  FixGate gate;
  EXPECT_TRUE(gate.keep(0.0, {0.0, 0.0}));
  EXPECT_TRUE(gate.keep(2.0, {30.0, 0.0}));
  EXPECT_FALSE(gate.keep(3.0, {45.001, 0.0}));
}

TEST(FixGate, LeavesOutAnotherPlaceAtTheSameOrAnEarlierTime) {
  FixGate gate;
  EXPECT_TRUE(gate.keep(5.0, {0.0, 0.0}));
  EXPECT_TRUE(gate.keep(5.0, {0.0, 0.0}));
  EXPECT_FALSE(gate.keep(5.0, {0.1, 0.0}));
  EXPECT_FALSE(gate.keep(4.0, {0.0, 0.0}));
}

TEST(FixGate, LeavesOutWhatIsNotANumber) {
  FixGate gate;
  EXPECT_TRUE(gate.keep(0.0, {0.0, 0.0}));
  EXPECT_FALSE(gate.keep(1.0, {std::numeric_limits<double>::quiet_NaN(), 0.0}));
}

}  // namespace
}  // namespace hymm::core
