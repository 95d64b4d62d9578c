#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>
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

/// A search in some maps of the wood, on a machine that does it in pieces of some size.
class InPieces : public ::testing::Test {
 protected:
  static constexpr std::size_t kAtOnce = std::numeric_limits<std::size_t>::max();

  InPieces() : search_(config(), vehicle()) {}

  static RelocaliserConfig config() {
    RelocaliserConfig config;
    config.global_particles = 10000;
    return config;
  }

  void begin() {
    std::string problem;
    ASSERT_TRUE(search_.beginAnywhere(maps_, Calibration{}, time_s_, problem)) << problem;
  }
  void take() {
    search_.take(TwistInput{time_s_, kSpeed_mps, 0.0, 0.0, std::nullopt});
    time_s_ += kScanPeriod_s;
    pose_ = pose_ * Pose2{kSpeed_mps * kScanPeriod_s, 0.0, 0.0};
    search_.take(seenFrom(pose_, landmarks_, time_s_));
  }
  /// Until a scan is in whose outcome a rival is looked for.
  void workIntoInquiry() {
    for (int scan = 0; scan < kScans; ++scan) {
      take();
      while (search_.work(1) != PlaceSearch::Progress::kNothingWaits) {
        if (search_.isSearchingRivals()) return;
      }
    }
    FAIL() << "There was no such scan.";
  }
  /// The places and doubts of all scans that wait.
  std::vector<std::string> tellAll(std::size_t rival_steps) {
    std::vector<std::string> told;
    for (auto progress = kPieceDone; progress != PlaceSearch::Progress::kNothingWaits;) {
      progress = search_.work(rival_steps);
      if (progress == kPieceDone) ++pieces_;
      if (progress != PlaceSearch::Progress::kScanDone || !search_.outcome()) continue;
      const RelocaliserOutcome& outcome = *search_.outcome();
      std::ostringstream line;
      line << std::hexfloat << search_.time_s() << ' ' << outcome.T_map_base.vector().transpose()
           << ' ' << outcome.converged << ' ' << outcome.particles << ' ' << outcome.doubt;
      told.push_back(line.str());
    }
    return told;
  }

  static constexpr auto kPieceDone = PlaceSearch::Progress::kPieceDone;
  static constexpr int kScans = 40;
  const JointLandmarks landmarks_ = wood();
  const std::vector<LocalMap> maps_ = neighbourhoods(landmarks_, 50.0);
  PlaceSearch search_;
  Pose2 pose_{120.0, 4.0, 0.4};
  double time_s_ = 0.0;
  std::size_t pieces_ = 0;
};

TEST_F(InPieces, FindsTheSameWhateverTheirSize) {
  const auto run = [](std::size_t rival_steps, bool is_late, std::size_t& pieces) {
    InPieces_FindsTheSameWhateverTheirSize_Test test;
    test.take();
    test.begin();
    std::vector<std::string> told;
    for (int i = 0; i < kScans; ++i) {
      test.take();
      if (is_late && i + 1 < kScans) continue;
      for (const std::string& line : test.tellAll(rival_steps)) told.push_back(line);
    }
    EXPECT_TRUE(test.search_.outcome() && test.search_.outcome()->converged);
    pieces = test.pieces_;
    return told;
  };
  std::size_t few = 0, many = 0, late = 0;
  const std::vector<std::string> at_once = run(kAtOnce, false, few);
  EXPECT_EQ(at_once, run(3000, false, many));
  EXPECT_EQ(at_once, run(3000, true, late));
  EXPECT_GT(many, few + 100);  // else there was nothing to do in pieces
  EXPECT_EQ(late, many);
}

TEST_F(InPieces, TellsNothingOfAScanUntilItIsDone) {
  take();
  begin();
  workIntoInquiry();
  const double time_s = search_.time_s();
  EXPECT_LT(time_s, time_s_);
  const auto doubt = [&] { return search_.outcome() ? search_.outcome()->doubt : "nothing"; };
  const std::string before = doubt();
  while (search_.work(3000) == kPieceDone) {
    EXPECT_EQ(search_.time_s(), time_s);
    EXPECT_EQ(doubt(), before);
  }
  EXPECT_EQ(search_.time_s(), time_s_);
}

TEST_F(InPieces, EndsAndIsResetInTheMiddle) {
  for (const bool is_reset : {false, true}) {
    take();
    begin();
    workIntoInquiry();
    if (is_reset) {
      search_.reset();
    } else {
      search_.end();
    }
    EXPECT_FALSE(search_.isOn());
    EXPECT_EQ(search_.engine(), nullptr);
    EXPECT_FALSE(search_.outcome());
    take();
    EXPECT_EQ(search_.work(), PlaceSearch::Progress::kNothingWaits);
  }
}

// What was begun before leaves nothing behind.
TEST_F(InPieces, BeginsAnewInTheMiddleAsAnyTime) {
  const auto run = [](bool in_the_middle) {
    InPieces_BeginsAnewInTheMiddleAsAnyTime_Test test;
    test.take();
    test.begin();
    if (in_the_middle) test.workIntoInquiry();
    const int scans = static_cast<int>(std::lround(test.time_s_ / kScanPeriod_s));
    for (int i = scans; i < kScans; ++i) test.take();
    test.time_s_ = kScanPeriod_s;
    test.begin();
    return test.tellAll(3000);
  };
  const std::vector<std::string> told = run(true);
  EXPECT_GT(told.size(), 10U);
  EXPECT_EQ(told, run(false));
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
