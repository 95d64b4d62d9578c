#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "relocaliser/neighbourhoods.h"
#include "relocaliser/place_search.h"
#include "tree_stand.h"

namespace hymm::core {
namespace {

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

std::vector<LandmarkEstimate> estimates(const JointLandmarks& landmarks) {
  std::vector<LandmarkEstimate> estimates;
  for (std::size_t i = 0; i < landmarks.ids.size(); ++i) {
    LandmarkEstimate estimate;
    estimate.id = landmarks.ids[i];
    estimate.position = landmarks.mean.segment<2>(2 * static_cast<Eigen::Index>(i));
    estimates.push_back(estimate);
  }
  return estimates;
}

ObservationSet seenFrom(const Pose2& T_map_base, const JointLandmarks& landmarks, double time_s) {
  return seenFrom(T_map_base, estimates(landmarks), time_s);
}

std::vector<LocalMap> neighbourhoods(const JointLandmarks& landmarks, double spacing_m) {
  std::vector<LocalMap> maps;
  for (const Eigen::Vector2d& middle : findMiddles(estimates(landmarks), spacing_m)) {
    std::string problem;
    if (auto map = tryMakeNeighbourhood(landmarks, middle, spacing_m, {}, problem)) {
      maps.push_back(std::move(*map));
    }
  }
  return maps;
}

TEST(Neighbourhoods, CoverAllLandmarks) {
  const JointLandmarks landmarks = wood();
  const LocalMapConfig config;
  std::set<int> covered;
  const auto maps = neighbourhoods(landmarks, 20.0);
  EXPECT_GT(maps.size(), 10U);
  for (const LocalMap& map : maps) {
    EXPECT_LE(map.landmarks.size(), static_cast<std::size_t>(config.max_landmarks));
    for (const LocalLandmark& landmark : map.landmarks) covered.insert(landmark.id);
  }
  EXPECT_EQ(covered.size(), landmarks.ids.size());
}

TEST(Neighbourhoods, AskForTheLandmarksAroundTheMiddle) {
  const std::vector<LandmarkEstimate> landmarks = estimates(wood());
  LocalMapConfig config;
  config.max_landmarks = 5;
  const std::vector<int> around = landmarksAround({100.0, 0.0}, landmarks, config);
  EXPECT_EQ(around.size(), 15U);
  EXPECT_TRUE(std::is_sorted(around.begin(), around.end()));
  double farthest_m = 0.0;
  for (const int id : around) {
    const Eigen::Vector2d& place = landmarks[static_cast<std::size_t>(id)].position;
    farthest_m = std::max(farthest_m, (place - Eigen::Vector2d(100.0, 0.0)).norm());
  }
  const auto nearer =
      std::count_if(landmarks.begin(), landmarks.end(), [&](const LandmarkEstimate& landmark) {
        return (landmark.position - Eigen::Vector2d(100.0, 0.0)).norm() <= farthest_m;
      });
  EXPECT_EQ(nearer, 15);
}

TEST(Neighbourhoods, AreNoneWhereNoTwoLandmarksKnowEachOther) {
  JointLandmarks landmarks = wood();
  landmarks.covariance *= 1e4;
  EXPECT_TRUE(neighbourhoods(landmarks, 20.0).empty());
}

TEST(PlaceSearch, FindsTheVehicleAnywhereInALargeMap) {
  const JointLandmarks landmarks = wood();
  RelocaliserConfig config;
  config.global_particles = 30000;
  PlaceSearch search(config, vehicle());
  const std::vector<LocalMap> maps = neighbourhoods(landmarks, 25.0);
  search.take(TwistInput{0.0, kSpeed_mps, 0.0, 0.0, std::nullopt});
  std::string problem;
  ASSERT_TRUE(search.beginAnywhere(maps, Calibration{}, 0.0, problem)) << problem;
  Pose2 pose{120.0, 4.0, 0.4};
  std::size_t fewest = maps.size();
  double time_s = 0.0;
  const auto is_found = [&] { return search.outcome() && search.outcome()->converged; };
  while (!is_found() && time_s < 12.0) {
    search.take(TwistInput{time_s, kSpeed_mps, 0.0, 0.0, std::nullopt});
    time_s += kScanPeriod_s;
    pose = pose * Pose2{kSpeed_mps * kScanPeriod_s, 0.0, 0.0};
    search.take(seenFrom(pose, landmarks, time_s));
    while (search.work() != PlaceSearch::Progress::kNothingWaits) {
    }
    fewest = std::min(fewest, search.mapsLeft());
  }
  ASSERT_TRUE(is_found());
  EXPECT_LT((search.outcome()->T_map_base.position() - pose.position()).norm(), 0.2);
  EXPECT_LT(fewest, maps.size() / 2);  // where the vehicle cannot be is not looked in for long
}

/// Two stands of trees that look alike, 100 m from each other, and each with a map of its own.
TEST(PlaceSearch, BelievesNothingWhereAnotherMapExplainsAsMuch) {
  JointLandmarks landmarks;
  RandomGenerator generator(4);
  constexpr int kTrees = 24;
  landmarks.mean.resize(4 * kTrees);
  for (int i = 0; i < kTrees; ++i) {
    const Eigen::Vector2d place(sampleUniform(generator, 0.0, 60.0),
                                sampleUniform(generator, -15.0, 15.0));
    landmarks.mean.segment<2>(2 * i) = place;
    landmarks.mean.segment<2>(2 * (kTrees + i)) = place + Eigen::Vector2d(0.0, 100.0);
  }
  for (int i = 0; i < 2 * kTrees; ++i) landmarks.ids.push_back(i);
  landmarks.covariance = 0.0025 * Eigen::MatrixXd::Identity(4 * kTrees, 4 * kTrees);
  RelocaliserConfig config;
  config.local_map.max_landmarks = kTrees;
  config.global_particles = 10000;
  PlaceSearch search(config, vehicle());
  search.take(TwistInput{0.0, kSpeed_mps, 0.0, 0.0, std::nullopt});
  std::string problem;
  ASSERT_TRUE(search.beginAnywhere(neighbourhoods(landmarks, 40.0), Calibration{}, 0.0, problem));
  Pose2 pose{5.0, 0.0, 0.0};
  std::string doubt;
  const auto is_rival_seen = [&] { return doubt.find("another part") != std::string::npos; };
  for (double time_s = kScanPeriod_s; time_s < 8.0 && !is_rival_seen(); time_s += kScanPeriod_s) {
    pose = pose * Pose2{kSpeed_mps * kScanPeriod_s, 0.0, 0.0};
    search.take(seenFrom(pose, landmarks, time_s));
    while (search.work() != PlaceSearch::Progress::kNothingWaits) {
    }
    ASSERT_TRUE(search.outcome());
    ASSERT_FALSE(search.outcome()->converged) << time_s;
    ASSERT_TRUE(search.pose());
    doubt = search.outcome()->doubt;
  }
  EXPECT_TRUE(is_rival_seen()) << doubt;
}

}  // namespace
}  // namespace hymm::core
