#include "ros/stamp_comparison.h"

#include <gmock/gmock.h>

namespace hymm {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using Source = StampComparison::Source;

/// A drive of 100 s, recorded from 1000 s on: motion at 50 Hz, scans at 10 Hz.
StampComparison drive(double scans_ahead_s, double scans_recorded_later_s = 0.0) {
  StampComparison stamps;
  for (int i = 0; i < 5000; ++i) {
    const double time_s = 1000.0 + 0.02 * i;
    stamps.add(Source::kMotion, time_s, time_s + 0.005);
    if (i % 5 != 0) continue;
    stamps.add(Source::kScan, time_s + scans_ahead_s, time_s + scans_recorded_later_s);
  }
  return stamps;
}

TEST(StampComparison, OneClockIsNotToldOf) {
  EXPECT_THAT(drive(0.0).problems(), IsEmpty());
  EXPECT_FALSE(drive(0.0).areApart());
}

TEST(StampComparison, ScansThatTakeATurnOfTheSensorAreNotToldOf) {
  EXPECT_THAT(drive(0.0, 0.15).problems(), IsEmpty());
}

TEST(StampComparison, AClockThatIsSecondsOffIsToldWithTheFigure) {
  EXPECT_THAT(drive(0.9).problems(),
              ElementsAre(AllOf(HasSubstr("0.905 s behind"), HasSubstr("clocks disagree"))));
  EXPECT_THAT(drive(-37.0).problems(), ElementsAre(HasSubstr("36.995 s ahead of")));
  EXPECT_FALSE(drive(-37.0).areApart());
}

TEST(StampComparison, ScansOfAnotherTimeAreApart) {
  for (const double ahead_s : {3600.0, -1000.0, 1.7e9}) {
    const StampComparison stamps = drive(ahead_s);
    EXPECT_TRUE(stamps.areApart()) << ahead_s;
    EXPECT_THAT(stamps.problems(),
                ElementsAre(HasSubstr("clocks disagree"), HasSubstr("Motion is stamped from")));
  }
}

TEST(StampComparison, MotionThatEndsEarlyIsTold) {
  StampComparison stamps;
  for (int i = 0; i < 1000; ++i) {
    const double time_s = 1.0 + 0.1 * i;
    if (i < 400) stamps.add(Source::kMotion, time_s, time_s);
    stamps.add(Source::kScan, time_s, time_s);
  }
  EXPECT_THAT(stamps.problems(), ElementsAre(HasSubstr("for most of the scans' time")));
  EXPECT_FALSE(stamps.areApart());
}

TEST(StampComparison, AFewStrayStampsHideNothing) {
  StampComparison stamps = drive(3600.0);
  for (int i = 0; i < 5; ++i) stamps.add(Source::kScan, 1050.0, 1050.0);
  EXPECT_TRUE(stamps.areApart());
}

TEST(StampComparison, StampsOfZeroAndASourceThatIsMissingSayNothing) {
  StampComparison stamps;
  for (int i = 1; i < 100; ++i) {
    stamps.add(Source::kMotion, 0.0, 100.0 + i);
    stamps.add(Source::kScan, 100.0 + i, 100.0 + i);
  }
  EXPECT_THAT(stamps.problems(), IsEmpty());
  EXPECT_FALSE(stamps.areApart());
}

TEST(StampComparison, LongRecordingsAreJudgedByASample) {
  StampComparison stamps;
  for (int i = 0; i < 300000; ++i) {
    stamps.add(Source::kMotion, 1.0 + 0.01 * i, 1.0 + 0.01 * i);
    stamps.add(Source::kScan, 1.5 + 0.01 * i, 1.0 + 0.01 * i);
  }
  EXPECT_THAT(stamps.problems(), ElementsAre(HasSubstr("0.500 s behind")));
}

}  // namespace
}  // namespace hymm
