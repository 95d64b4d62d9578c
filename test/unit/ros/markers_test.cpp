#include "ros/markers.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>

namespace hymm {
namespace {

using testing::SizeIs;
using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

core::LandmarkMap twoLandmarks() {
  core::LandmarkMap map;
  map.time_s = 12.5;
  map.landmarks.resize(2);
  map.landmarks[0].id = 3;
  map.landmarks[0].type = core::LandmarkType::kTrunk;
  map.landmarks[0].position = {10.0, -4.0};
  map.landmarks[0].covariance << 0.09, 0.0, 0.0, 0.01;  // deviations 0.3 m and 0.1 m
  map.landmarks[0].diameter_m = 0.8;
  map.landmarks[1].id = 7;
  map.landmarks[1].type = core::LandmarkType::kReflector;
  map.landmarks[1].position = {20.0, 5.0};
  map.landmarks[1].diameter_m = std::numeric_limits<double>::quiet_NaN();
  return map;
}

std::vector<Marker> named(const MarkerArray& array, const std::string& name) {
  std::vector<Marker> found;
  for (const Marker& marker : array.markers) {
    if (marker.ns == name) found.push_back(marker);
  }
  return found;
}

/// Largest distance of points from `centre` along each axis.
Eigen::Vector2d reach(const Marker& marker, const Eigen::Vector2d& centre, std::size_t first,
                      std::size_t end) {
  Eigen::Vector2d largest = Eigen::Vector2d::Zero();
  for (std::size_t i = first; i < end; ++i) {
    const Eigen::Vector2d p(marker.points[i].x, marker.points[i].y);
    largest = largest.cwiseMax((p - centre).cwiseAbs());
  }
  return largest;
}

TEST(LandmarkMarkers, EveryLandmarkIsADiscOfItsPlaceSizeAndType) {
  const MarkerArray array = landmarkMarkers(twoLandmarks(), "map");
  const std::vector<Marker> discs = named(array, "landmarks");
  ASSERT_THAT(discs, SizeIs(2));
  EXPECT_EQ(discs[0].id, 3);
  EXPECT_EQ(discs[0].header.frame_id, "map");
  EXPECT_EQ(discs[0].header.stamp, ros::Time(12.5));
  EXPECT_EQ(discs[0].pose.position.x, 10.0);
  EXPECT_EQ(discs[0].pose.position.y, -4.0);
  EXPECT_EQ(discs[0].scale.x, 0.8);
  EXPECT_EQ(discs[1].scale.x, 0.6);  // no diameter known: still to be seen
  EXPECT_GT(discs[0].color.g, discs[0].color.r);
  EXPECT_GT(discs[1].color.r, discs[1].color.g);
}

TEST(LandmarkMarkers, EllipsesReachTwoDeviationsAndTenTimesThat) {
  const MarkerArray array = landmarkMarkers(twoLandmarks(), "map");
  const std::vector<Marker> ellipses = named(array, "two_sigma");
  const std::vector<Marker> magnified = named(array, "two_sigma_magnified_10x");
  ASSERT_THAT(ellipses, SizeIs(1));
  ASSERT_THAT(magnified, SizeIs(1));
  const std::size_t first_landmark = ellipses[0].points.size() / 2;
  const Eigen::Vector2d centre(10.0, -4.0);
  EXPECT_LT((reach(ellipses[0], centre, 0, first_landmark) - Eigen::Vector2d(0.6, 0.2)).norm(),
            1e-12);
  EXPECT_LT((reach(magnified[0], centre, 0, first_landmark) - Eigen::Vector2d(6.0, 2.0)).norm(),
            1e-12);
}

TEST(LandmarkMarkers, ClearFirstWhatMayBeGone) {
  const MarkerArray array = landmarkMarkers({}, "map");
  ASSERT_THAT(array.markers, SizeIs(1));  // RViz complains of lists without points
  EXPECT_EQ(array.markers[0].action, Marker::DELETEALL);
}

TEST(ObservationMarkers, RaysGoFromTheSensorToWhatItSees) {
  core::ScanOutcome outcome;
  outcome.pose.T_map_base = {100.0, 50.0, core::kPi / 2.0};
  outcome.observations.T_base_sensor = {3.0, 0.0, 0.0};
  outcome.observations.observations.resize(3);
  outcome.observations.observations[0].range_m = 10.0;  // straight ahead: north
  outcome.associations = {{4}, {core::Association::kTentative}, {core::Association::kRejected}};
  const MarkerArray array = observationMarkers(outcome, "map");
  ASSERT_THAT(array.markers, SizeIs(1));
  const Marker& rays = array.markers[0];
  ASSERT_THAT(rays.points, SizeIs(6));
  EXPECT_NEAR(rays.points[0].x, 100.0, 1e-9);
  EXPECT_NEAR(rays.points[0].y, 53.0, 1e-9);
  EXPECT_NEAR(rays.points[1].x, 100.0, 1e-9);
  EXPECT_NEAR(rays.points[1].y, 63.0, 1e-9);
  ASSERT_THAT(rays.colors, SizeIs(6));
  EXPECT_GT(rays.colors[0].g, 0.9F);  // green, yellow, red
  EXPECT_LT(rays.colors[0].r, 0.5F);
  EXPECT_GT(rays.colors[2].r, 0.9F);
  EXPECT_GT(rays.colors[2].g, 0.5F);
  EXPECT_GT(rays.colors[4].r, 0.9F);
  EXPECT_LT(rays.colors[4].g, 0.5F);
}

TEST(ObservationMarkers, AScanWithoutObservationsTakesTheOldRaysAway) {
  const MarkerArray array = observationMarkers({}, "map");
  ASSERT_THAT(array.markers, SizeIs(1));
  EXPECT_EQ(array.markers[0].action, Marker::DELETE);
}

}  // namespace
}  // namespace hymm
