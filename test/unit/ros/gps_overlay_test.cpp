#include "ros/gps_overlay.h"

#include <cmath>

#include <gmock/gmock.h>

namespace hymm {
namespace {

using testing::HasSubstr;
using testing::SizeIs;
using visualization_msgs::Marker;

const GeographicLib::LocalCartesian kFrame(-33.9, 151.2, 40.0);

sensor_msgs::NavSatFix fixAt(double time_s, const Eigen::Vector2d& east_north_m) {
  sensor_msgs::NavSatFix message;
  message.header.stamp = ros::Time(time_s);
  message.status.status = sensor_msgs::NavSatStatus::STATUS_FIX;
  kFrame.Reverse(east_north_m.x(), east_north_m.y(), 0.0, message.latitude, message.longitude,
                 message.altitude);
  message.position_covariance = {0.25, 0, 0, 0, 0.25, 0, 0, 0, 1.0};
  message.position_covariance_type = sensor_msgs::NavSatFix::COVARIANCE_TYPE_DIAGONAL_KNOWN;
  return message;
}

TEST(GpsConverter, FirstUsableFixIsTheOrigin) {
  GpsConverter converter({3.0, 0.5});
  sensor_msgs::NavSatFix none = fixAt(1.0, {500.0, 500.0});
  none.status.status = sensor_msgs::NavSatStatus::STATUS_NO_FIX;
  EXPECT_FALSE(converter.convert(none).fix);
  const auto first = converter.convert(fixAt(2.0, {10.0, 20.0})).fix;
  const auto second = converter.convert(fixAt(3.0, {40.0, -20.0})).fix;
  ASSERT_TRUE(first && second);
  EXPECT_NEAR(first->position.norm(), 0.0, 1e-6);
  EXPECT_NEAR((second->position - Eigen::Vector2d(30.0, -40.0)).norm(), 0.0, 1e-3);
  EXPECT_EQ(second->time_s, 3.0);
  EXPECT_EQ(second->antenna, Eigen::Vector2d(3.0, 0.5));
  EXPECT_EQ(second->covariance(0, 0), 0.25);
  converter.reset();
  EXPECT_NEAR(converter.convert(fixAt(4.0, {7.0, 8.0})).fix->position.norm(), 0.0, 1e-6);
}

TEST(GpsConverter, SaysWhyAFixIsRefused) {
  GpsConverter converter({0.0, 0.0});
  const auto problemOf = [&](auto spoil) {
    sensor_msgs::NavSatFix message = fixAt(1.0, {0.0, 0.0});
    spoil(message);
    const GpsConverter::Answer answer = converter.convert(message);
    EXPECT_FALSE(answer.fix);
    return answer.problem;
  };
  EXPECT_THAT(problemOf([](auto& m) { m.latitude = std::nan(""); }), HasSubstr("latitude"));
  EXPECT_THAT(problemOf([](auto& m) { m.latitude = 91.0; }), HasSubstr("latitude"));
  EXPECT_THAT(problemOf([](auto& m) { m.longitude = INFINITY; }), HasSubstr("longitude"));
  EXPECT_THAT(problemOf([](auto& m) { m.status.status = -1; }), HasSubstr("no fix"));
  EXPECT_THAT(problemOf([](auto& m) { m.position_covariance[1] = 0.1; }), HasSubstr("symmetric"));
  EXPECT_THAT(problemOf([](auto& m) { m.position_covariance[0] = -1.0; }), HasSubstr("definite"));
}

/// A vehicle that drives around a corner; GPS knows its map only up to a motion of the plane.
class GpsOverlayTest : public testing::Test {
 protected:
  static core::Pose2 poseAt(int second) {
    const double way_m = 5.0 * second;
    if (way_m <= 50.0) return {way_m, 0.0, 0.0};
    return {50.0, way_m - 50.0, core::kPi / 2.0};
  }
  static Eigen::Vector2d antennaAt(int second) { return poseAt(second) * kAntenna; }
  static sensor_msgs::NavSatFix trueFix(int second) {
    return fixAt(second, kT_gps_map * antennaAt(second));
  }
  void expectPointsAt(const std::vector<int>& seconds) const {
    const Marker marker = overlay_.marker();
    ASSERT_EQ(marker.action, Marker::ADD);
    ASSERT_THAT(marker.points, SizeIs(seconds.size()));
    for (std::size_t i = 0; i < seconds.size(); ++i) {
      const Eigen::Vector2d p_map(marker.points[i].x, marker.points[i].y);
      EXPECT_LT((p_map - antennaAt(seconds[i])).norm(), 0.01) << seconds[i];
    }
  }

  inline static const Eigen::Vector2d kAntenna{3.0, 0.5};
  inline static const core::Pose2 kT_gps_map{120.0, -40.0, 0.7};
  GpsOverlay overlay_{kAntenna, "map"};
};

TEST_F(GpsOverlayTest, LaysFixesOverTheAntennasWay) {
  for (int second = 0; second <= 20; ++second) {
    overlay_.addFix(trueFix(second));
    overlay_.addPose(second, poseAt(second));
  }
  EXPECT_EQ(overlay_.count(), 21u);
  EXPECT_EQ(overlay_.marker().header.frame_id, "map");
  expectPointsAt({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20});
}

TEST_F(GpsOverlayTest, ShowsNothingUntilThreeFixesTellHowToLayThem) {
  for (int second = 0; second < 2; ++second) {
    overlay_.addFix(trueFix(second));
    overlay_.addPose(second, poseAt(second));
  }
  EXPECT_EQ(overlay_.marker().action, Marker::DELETE);
  overlay_.addFix(trueFix(12));
  for (int second = 2; second <= 12; ++second) overlay_.addPose(second, poseAt(second));
  expectPointsAt({0, 1, 12});
}

TEST_F(GpsOverlayTest, LeavesOutAFixThatCannotBeReached) {
  for (int second = 0; second <= 12; ++second) {
    overlay_.addFix(second == 6 ? fixAt(6, {500.0, 500.0}) : trueFix(second));
    overlay_.addPose(second, poseAt(second));
  }
  expectPointsAt({0, 1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 12});
}

TEST_F(GpsOverlayTest, LeavesOutAFixInAGapOfPoses) {
  for (int second = 0; second <= 12; ++second) {
    if (second != 5 && second != 6 && second != 7) overlay_.addPose(second, poseAt(second));
    overlay_.addFix(trueFix(second));
  }
  expectPointsAt({0, 1, 2, 3, 4, 8, 9, 10, 11, 12});
}

TEST_F(GpsOverlayTest, AFixMayComeLaterThanThePosesAroundIt) {
  for (int second = 0; second <= 12; ++second) {
    overlay_.addPose(second, poseAt(second));
    if (second >= 3) overlay_.addFix(trueFix(second - 3));
  }
  expectPointsAt({0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
}

TEST_F(GpsOverlayTest, AFixFarAheadDoesNotHoldUpThoseAfterIt) {
  for (int second = 0; second <= 12; ++second) {
    overlay_.addFix(second == 6 ? fixAt(106, kT_gps_map * antennaAt(6)) : trueFix(second));
    overlay_.addPose(second, poseAt(second));
  }
  expectPointsAt({0, 1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 12});
}

TEST_F(GpsOverlayTest, KeepsAThousandFixesOfAClockFarAhead) {
  for (int second = 0; second <= 3000; ++second) {
    overlay_.addFix(fixAt(second + 1e6, {0.0, 0.0}));
    overlay_.addPose(second, poseAt(second));
  }
  for (int second = 0; second <= 3000; ++second) {
    overlay_.addPose(1e6 + second, {0.0, 0.0, 0.0});
  }
  EXPECT_EQ(overlay_.count(), 1000u);
}

TEST_F(GpsOverlayTest, ForgetsEverythingWhenAnotherMapBegins) {
  for (int second = 0; second <= 12; ++second) {
    overlay_.addFix(trueFix(second));
    overlay_.addPose(second, poseAt(second));
  }
  overlay_.clear();
  EXPECT_EQ(overlay_.count(), 0u);
  EXPECT_EQ(overlay_.marker().action, Marker::DELETE);
}

}  // namespace
}  // namespace hymm
