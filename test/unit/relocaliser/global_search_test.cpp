#include "relocaliser/global_search.h"

#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "relocaliser/neighbourhoods.h"

namespace hymm::core {
namespace {

constexpr double kScanPeriod_s = 0.2;
constexpr double kSpeed_mps = 4.0;

/// Trees strewn over 200 m x 60 m, each known to 5 cm.
JointLandmarks wood() {
  RandomGenerator generator(2);
  JointLandmarks landmarks;
  constexpr int kTrees = 120;
  landmarks.mean.resize(2 * kTrees);
  landmarks.covariance = 0.0025 * Eigen::MatrixXd::Identity(2 * kTrees, 2 * kTrees);
  for (int i = 0; i < kTrees; ++i) {
    landmarks.ids.push_back(i);
    landmarks.mean[2 * i] = sampleUniform(generator, 0.0, 200.0);
    landmarks.mean[2 * i + 1] = sampleUniform(generator, -30.0, 30.0);
  }
  return landmarks;
}

VehicleConfig vehicle() {
  VehicleConfig config;
  config.laser = {2.0, 0.3, 0.0};
  return config;
}

ObservationSet seenFrom(const Pose2& T_map_base, const JointLandmarks& landmarks, double time_s) {
  ObservationSet set{time_s, vehicle().laser.T_base_sensor(), {}};
  for (Eigen::Index row = 0; row < landmarks.mean.size(); row += 2) {
    const Eigen::Vector2d p =
        inverse(T_map_base * set.T_base_sensor) * landmarks.mean.segment<2>(row);
    if (p.norm() > 25.0 || p.x() < 0.0) continue;
    Observation observation;
    observation.range_m = p.norm();
    observation.bearing_rad = std::atan2(p.y(), p.x());
    observation.covariance = Eigen::Vector2d(0.0025, 0.000025).asDiagonal();
    set.observations.push_back(observation);
  }
  return set;
}

TEST(Neighbourhoods, CoverAllLandmarks) {
  const JointLandmarks landmarks = wood();
  const LocalMapConfig config;
  std::set<int> covered;
  const auto maps = makeNeighbourhoods(landmarks, 20.0, config);
  EXPECT_GT(maps.size(), 10U);
  for (const LocalMap& map : maps) {
    EXPECT_LE(map.landmarks.size(), static_cast<std::size_t>(config.max_landmarks));
    for (const LocalLandmark& landmark : map.landmarks) covered.insert(landmark.id);
  }
  EXPECT_EQ(covered.size(), landmarks.ids.size());
}

TEST(Neighbourhoods, AreNoneWhereNoTwoLandmarksKnowEachOther) {
  JointLandmarks landmarks = wood();
  landmarks.covariance *= 1e4;
  EXPECT_TRUE(makeNeighbourhoods(landmarks, 20.0, {}).empty());
}

TEST(GlobalSearch, FindsTheVehicleAnywhereInALargeMap) {
  const JointLandmarks landmarks = wood();
  RelocaliserConfig config;
  config.global_particles = 30000;
  GlobalSearch search(config, vehicle(), Calibration{}, makeNeighbourhoods(landmarks, 25.0, {}),
                      10.0, RandomGenerator(1));
  search.begin(0.0);
  Pose2 pose{120.0, 4.0, 0.4};
  std::optional<RelocaliserOutcome> found;
  double time_s = 0.0;
  while (!found && time_s < 12.0) {
    search.process(TwistInput{time_s, kSpeed_mps, 0.0, 0.0, std::nullopt});
    time_s += kScanPeriod_s;
    pose = pose * Pose2{kSpeed_mps * kScanPeriod_s, 0.0, 0.0};
    found = search.process(seenFrom(pose, landmarks, time_s));
  }
  ASSERT_TRUE(found);
  EXPECT_LT((found->T_map_base.position() - pose.position()).norm(), 0.2);
}

TEST(GlobalSearch, NeedsAMap) {
  EXPECT_THROW(
      GlobalSearch({}, vehicle(), Calibration{}, std::vector<LocalMap>{}, 10.0, RandomGenerator(1)),
      std::invalid_argument);
}

}  // namespace
}  // namespace hymm::core
