#include <gmock/gmock.h>

#include "scan_evidence.h"

namespace hymm::core {
namespace {

using ::testing::HasSubstr;

TEST(Suspicion, FallsOnEachKindOfFailureAlone) {
  const SuspicionConfig config;
  EXPECT_EQ(findSuspicion(healthy().scan, config), "");
  ScanEvidence among_old = healthy().scan;
  among_old.old_landmarks_expected = 3;
  ScanEvidence scan = among_old;
  scan.ambiguity = 0.6;
  EXPECT_THAT(findSuspicion(scan, config), HasSubstr("ambiguous"));
  scan = healthy().scan;
  scan.nis = 60.0;
  EXPECT_THAT(findSuspicion(scan, config), HasSubstr("do not fit"));
  scan = among_old;
  scan.disagreement = 0.6;
  EXPECT_THAT(findSuspicion(scan, config), HasSubstr("grid"));
  scan = among_old;
  scan.unseen = 1.0;
  EXPECT_THAT(findSuspicion(scan, config), HasSubstr("old landmarks"));
}

TEST(Suspicion, DoesNotFallOnExploring) {
  ScanEvidence scan = healthy().scan;
  scan.unexplained = scan.ambiguity = scan.disagreement = scan.unseen = 1.0;
  scan.old_landmarks_expected = 2;
  EXPECT_EQ(findSuspicion(scan, {}), "");
  scan.ambiguity = scan.disagreement = scan.unseen = 0.0;
  scan.old_landmarks_expected = 3;
  EXPECT_THAT(findSuspicion(scan, {}), HasSubstr("old landmarks"));
}

TEST(Suspicion, NeverFallsOnALargeDeviationAlone) {
  ScanEvidence scan = healthy().scan;
  scan.position_deviation_m = 50.0;
  scan.heading_deviation_rad = 1.0;
  EXPECT_TRUE(isArmed(scan, {}));
  EXPECT_EQ(findSuspicion(scan, {}), "");
}

}  // namespace
}  // namespace hymm::core
