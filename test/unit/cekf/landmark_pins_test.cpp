#include "cekf/landmark_pins.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cekf/cekf_slam.h"
#include "support/analytic_laser.h"

namespace hymm::core {
namespace {

using testing::Contains;
using testing::IsEmpty;
using testing::Not;
using testing::UnorderedElementsAre;

TEST(LandmarkPins, AreInForceFromTheDelayOn) {
  LandmarkPins pins(2.0);
  pins.tell(10.0, {3, 5});
  EXPECT_THAT(pins.at(11.9), IsEmpty());
  EXPECT_THAT(pins.at(12.0), UnorderedElementsAre(3, 5));
  pins.tell(13.0, {5});
  EXPECT_THAT(pins.at(14.9), UnorderedElementsAre(3, 5));
  EXPECT_THAT(pins.at(15.0), UnorderedElementsAre(5));
}

TEST(LandmarkPins, LaterWordOfAnEarlierTimeReplacesWhatFollows) {
  LandmarkPins pins(2.0);
  pins.tell(10.0, {1});
  pins.tell(11.0, {2});
  pins.tell(10.5, {3});  // whoever tells began anew
  EXPECT_THAT(pins.at(20.0), UnorderedElementsAre(3));
  pins.clear();
  EXPECT_THAT(pins.at(30.0), IsEmpty());
}

/// A vehicle that comes nearer to three trunks, of which the farthest is felled after ten scans.
class FelledTrunk : public testing::Test {
 protected:
  void scan(int count) {
    for (int i = 0; i < count; ++i, time_s_ += 0.5) {
      const double x = kSpeed_mps * time_s_;
      AnalyticLaser laser;
      laser.disc(24.0 - x, 6.0, 0.4)
          .disc(24.0 - x, -7.0, 0.4)
          .wall(40.0 - x, -50.0, 40.0 - x, 50.0);
      if (time_s_ < 5.0) laser.disc(20.0 - x, 0.0, 0.4);
      ScanEvent event;
      event.scan = laser.scan(-kPi / 2.0, kPi / 360.0, 361);
      event.scan.time_s = time_s_;
      slam_.process(MotionInput{TwistInput{time_s_ - 0.5, kSpeed_mps, 0.0, 0.0}});
      slam_.process(event);
    }
  }

  std::vector<int> landmarks() {
    std::vector<int> ids;
    for (const LandmarkEstimate& landmark : slam_.landmarkMap(0.0).landmarks) {
      ids.push_back(landmark.id);
    }
    return ids;
  }

  int felled() {
    for (const LandmarkEstimate& landmark : slam_.landmarkMap(0.0).landmarks) {
      if (std::abs(landmark.position.y()) < 1.0) return landmark.id;
    }
    return -1;
  }

  static constexpr double kSpeed_mps = 0.5;
  CekfSlam slam_{CekfSlamConfig{}, VehicleConfig{}};
  double time_s_ = 0.0;
};

TEST_F(FelledTrunk, IsDropped) {
  scan(10);
  const int id = felled();
  ASSERT_GE(id, 0);
  scan(20);
  EXPECT_THAT(landmarks(), Not(Contains(id)));
}

TEST_F(FelledTrunk, StaysWhilePinned) {
  scan(10);
  const int id = felled();
  ASSERT_GE(id, 0);
  slam_.pinLandmarks(2.0, {id});
  scan(20);
  EXPECT_THAT(landmarks(), Contains(id));
  slam_.pinLandmarks(time_s_, {});
  scan(20);
  EXPECT_THAT(landmarks(), Not(Contains(id)));
}

TEST_F(FelledTrunk, IsDroppedWhereThePinComesTooLate) {
  scan(10);
  const int id = felled();
  ASSERT_GE(id, 0);
  slam_.pinLandmarks(time_s_ + 60.0, {id});
  scan(20);
  EXPECT_THAT(landmarks(), Not(Contains(id)));
}

}  // namespace
}  // namespace hymm::core
