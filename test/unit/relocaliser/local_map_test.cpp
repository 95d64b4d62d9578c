#include "relocaliser/local_map.h"

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "support/random_maps.h"

namespace hymm::core {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// Landmarks on a line, each known to `deviation_m`, and a vehicle at the origin.
VehicleAmongLandmarks lineOfLandmarks(int count, double deviation_m) {
  VehicleAmongLandmarks estimate;
  estimate.landmarks.mean = Eigen::VectorXd::Zero(2 * count);
  for (int i = 0; i < count; ++i) {
    estimate.landmarks.ids.push_back(10 + i);
    estimate.landmarks.mean.segment<2>(2 * i) << 5.0 * i + 5.0, 1.0 * i * i;
  }
  estimate.landmarks.covariance =
      deviation_m * deviation_m * Eigen::MatrixXd::Identity(2 * count, 2 * count);
  estimate.vehicle.covariance = Eigen::Vector3d(0.04, 0.04, 0.01).asDiagonal();
  return estimate;
}

std::vector<int> idsOf(const LocalMap& map) {
  std::vector<int> ids;
  for (const LocalLandmark& landmark : map.landmarks) ids.push_back(landmark.id);
  return ids;
}

std::optional<LocalMap> makeMap(const VehicleAmongLandmarks& estimate, LocalMapConfig config = {}) {
  config.travel_m = 0.0;
  std::string problem;
  return tryMakeLocalMap(estimate, 30.0, config, problem);
}

std::string problemOf(const VehicleAmongLandmarks& estimate) {
  std::string problem;
  EXPECT_FALSE(tryMakeLocalMap(estimate, 30.0, {}, problem).has_value());
  return problem;
}

TEST(LocalMap, PlacesVehicleAndLandmarksAsTheMapHasThem) {
  const VehicleAmongLandmarks estimate = lineOfLandmarks(5, 0.05);
  const auto map = makeMap(estimate);
  ASSERT_TRUE(map);
  EXPECT_THAT(idsOf(*map), ElementsAre(10, 11, 12, 13, 14));
  for (std::size_t i = 0; i < map->landmarks.size(); ++i) {
    const Eigen::Vector2d in_map = map->T_map_local * map->landmarks[i].position;
    const auto row = 2 * static_cast<Eigen::Index>(i);
    EXPECT_NEAR((in_map - estimate.landmarks.mean.segment<2>(row)).norm(), 0.0, 1e-12);
  }
  const Pose2 vehicle = map->T_map_local * map->vehicle.mean;
  EXPECT_NEAR(vehicle.vector().norm(), 0.0, 1e-12);
}

TEST(LocalMap, KeepsTheNearest) {
  LocalMapConfig config;
  config.max_landmarks = 3;
  const auto map = makeMap(lineOfLandmarks(6, 0.05), config);
  ASSERT_TRUE(map);
  EXPECT_THAT(idsOf(*map), ElementsAre(10, 11, 12));
}

TEST(LocalMap, LeavesOutWhatTheSensorCannotReach) {
  VehicleAmongLandmarks estimate = lineOfLandmarks(4, 0.05);
  estimate.landmarks.mean.tail<2>() << 40.0, 0.0;
  EXPECT_THAT(idsOf(makeMap(estimate).value()), ElementsAre(10, 11, 12));
}

TEST(LocalMap, LeavesOutWhatIsKnownTooLittle) {
  VehicleAmongLandmarks estimate = lineOfLandmarks(4, 0.05);
  estimate.landmarks.covariance.block<2, 2>(2, 2) *= 1600.0;  // 2 m
  EXPECT_THAT(idsOf(makeMap(estimate).value()), ElementsAre(10, 12, 13));
}

// The vehicle has come round a loop: it is 5 m off, and so are the landmarks that it has made
// since.
TEST(LocalMap, LeavesOutLandmarksThatCameAlongWithTheVehicle) {
  VehicleAmongLandmarks estimate = lineOfLandmarks(5, 0.05);
  const Eigen::Matrix2d drift = 25.0 * Eigen::Matrix2d::Identity();
  estimate.vehicle.covariance.topLeftCorner<2, 2>() += drift;
  estimate.cross_covariance = Eigen::MatrixXd::Zero(3, 10);
  estimate.cross_covariance.block<2, 2>(0, 2) = drift;
  estimate.landmarks.covariance.block<2, 2>(2, 2) += drift;
  const auto map = makeMap(estimate);
  ASSERT_TRUE(map);
  EXPECT_THAT(idsOf(*map), ElementsAre(10, 12, 13, 14));
}

TEST(LocalMap, SaysThatOneLandmarkIsTooFew) {
  EXPECT_THAT(problemOf(lineOfLandmarks(1, 0.1)), HasSubstr("1 landmark(s)"));
}

TEST(LocalMap, SaysThatAllLandmarksAreTooVague) {
  EXPECT_THAT(problemOf(lineOfLandmarks(3, 10.0)), HasSubstr("Fewer than two landmarks"));
}

TEST(LocalMap, RefusesAnEstimateOfWrongSize) {
  VehicleAmongLandmarks estimate = lineOfLandmarks(3, 0.1);
  estimate.landmarks.covariance.conservativeResize(5, 6);
  EXPECT_THAT(problemOf(estimate), HasSubstr("wrong size"));
}

TEST(LocalMap, RefusesAnEstimateThatIsNotFinite) {
  VehicleAmongLandmarks estimate = lineOfLandmarks(3, 0.1);
  estimate.landmarks.mean[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(problemOf(estimate), HasSubstr("not finite"));
}

}  // namespace
}  // namespace hymm::core
