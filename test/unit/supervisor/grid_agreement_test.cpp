#include "supervisor/grid_agreement.h"

#include <cmath>

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

TEST(GridAgreement, KnowsNothingBeforeItIsTold) {
  EXPECT_EQ(GridAgreement().disagreementAt(10.0), 0.0);
}

TEST(GridAgreement, JudgesAScanByWhatWasToldOfOneASecondBefore) {
  GridAgreement agreement;
  agreement.take(10.0, 0.9);
  agreement.take(11.0, 0.3);
  EXPECT_DOUBLE_EQ(agreement.disagreementAt(10.5), 0.0);
  EXPECT_DOUBLE_EQ(agreement.disagreementAt(11.5), 1.0 - 0.9);
  EXPECT_DOUBLE_EQ(agreement.disagreementAt(12.0), 1.0 - 0.3);
}

TEST(GridAgreement, SaysTheSameWhetherOrNotLaterFiguresHaveCome) {
  GridAgreement early, late;
  early.take(10.0, 0.8);
  late.take(10.0, 0.8);
  late.take(11.2, 0.1);
  EXPECT_EQ(early.disagreementAt(12.0), late.disagreementAt(12.0));
}

TEST(GridAgreement, ForgetsWhatIsOfAnotherPlace) {
  GridAgreement agreement;
  agreement.take(10.0, 0.2);
  EXPECT_DOUBLE_EQ(agreement.disagreementAt(12.9), 0.8);
  EXPECT_EQ(agreement.disagreementAt(13.1), 0.0);
}

TEST(GridAgreement, TakesUnknownForNoDisagreementAndKeepsWithinOne) {
  GridAgreement agreement;
  agreement.take(10.0, std::nan(""));
  EXPECT_EQ(agreement.disagreementAt(11.5), 0.0);
  agreement.take(12.0, -0.4);
  EXPECT_EQ(agreement.disagreementAt(13.5), 1.0);
}

TEST(GridAgreement, BeginsAnewWhereTheClockRanBack) {
  GridAgreement agreement;
  agreement.take(100.0, 0.1);
  agreement.take(1.0, 1.0);
  EXPECT_EQ(agreement.disagreementAt(101.0), 0.0);
  EXPECT_EQ(agreement.disagreementAt(2.5), 0.0);
}

}  // namespace
}  // namespace hymm::core
