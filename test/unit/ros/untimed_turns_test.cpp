#include "ros/untimed_turns.h"

#include <algorithm>
#include <limits>
#include <optional>

#include <gmock/gmock.h>

#include "common/angles.h"

namespace hymm {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

class UntimedTurnsTest : public testing::Test {
 protected:
  void drive(double forward_mps) { turns_.take(core::TwistInput{0.0, forward_mps, 0.0, 0.0}); }

  static core::LaserScan scanAt(double time_s, double view_rad = 2.0 * core::kPi) {
    core::LaserScan scan;
    scan.time_s = time_s;
    scan.angle_min_rad = -0.5 * view_rad;
    scan.angle_increment_rad = view_rad / 360.0;
    scan.ranges_m.assign(360, 5.0F);
    return scan;
  }

  UntimedTurns turns_;
  CauseLog causes_;
};

TEST_F(UntimedTurnsTest, AreToldWithWhatTheyCost) {
  drive(12.0);
  turns_.take(scanAt(0.0), 0.1, "laser", causes_);
  EXPECT_EQ(causes_.total(), 1U);
  drive(15.0);
  turns_.take(scanAt(0.1), 0.1, "laser", causes_);
  drive(5.0);
  turns_.take(scanAt(0.2), 0.1, "laser", causes_);
  EXPECT_THAT(turns_.summary(), HasSubstr("moved up to 1.5 m during a scan of frame 'laser'"));
}

TEST_F(UntimedTurnsTest, OfSlowVehiclesAndFastLasersAreNot) {
  drive(1.9);
  turns_.take(scanAt(0.0), 0.1, "laser", causes_);
  EXPECT_EQ(causes_.total(), 0U);
  EXPECT_THAT(turns_.summary(), IsEmpty());
}

TEST_F(UntimedTurnsTest, AreNotOfALaserThatSeesASectorOnly) {
  drive(12.0);
  turns_.take(scanAt(0.0, core::kPi), 0.1, "laser", causes_);
  core::LaserScan camera = scanAt(0.0);
  std::fill(camera.ranges_m.begin(), camera.ranges_m.begin() + 270,
            std::numeric_limits<float>::quiet_NaN());
  turns_.take(camera, 0.1, "camera", causes_);
  EXPECT_EQ(causes_.total(), 0U);
}

TEST_F(UntimedTurnsTest, TakeThePeriodFromStampsWhereItIsNotTold) {
  drive(5.0);
  for (const double time_s : {0.0, 0.1, 0.2}) {
    turns_.take(scanAt(time_s), std::nullopt, "lidar", causes_);
  }
  EXPECT_EQ(causes_.total(), 1U);                            // two differences are needed
  turns_.take(scanAt(0.7), std::nullopt, "lidar", causes_);  // some got lost
  EXPECT_THAT(turns_.summary(), HasSubstr("up to 0.5 m"));
}

}  // namespace
}  // namespace hymm
