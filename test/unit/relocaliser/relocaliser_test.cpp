#include "relocaliser/relocaliser.h"

#include <cmath>
#include <vector>

#include <Eigen/LU>
#include <gmock/gmock.h>

#include "relocaliser/visible_landmarks.h"
#include "tree_stand.h"

namespace hymm::core {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kSpeed_mps = 4.0;

/// Two rows of trees that look alike wherever one stands.
LocalMap avenue() {
  LocalMap map = stand();
  map.landmarks.clear();
  for (int i = -20; i < 40; ++i) {
    const double x = 5.0 * i;
    map.landmarks.push_back({2 * i + 40, {x, 6.0}, 0.0025 * Eigen::Matrix2d::Identity()});
    map.landmarks.push_back({2 * i + 41, {x, -6.0}, 0.0025 * Eigen::Matrix2d::Identity()});
  }
  map.vehicle.covariance = Eigen::Vector3d(36.0, 1.0, 0.01).asDiagonal();
  return map;
}

/// Drives straight on through `world`, which may be another than the relocaliser's map.
class Drive {
 public:
  Drive(Relocaliser& relocaliser, const LocalMap& world, const Pose2& start)
      : relocaliser_(relocaliser), world_(world), pose_(start) {}

  std::optional<RelocaliserOutcome> scan() {
    relocaliser_.process(TwistInput{time_s_, kSpeed_mps, 0.0, 0.0, std::nullopt});
    time_s_ += kScanPeriod_s;
    pose_ = pose_ * Pose2{kSpeed_mps * kScanPeriod_s, 0.0, 0.0};
    return relocaliser_.process(seenFrom(pose_, world_.landmarks, time_s_));
  }
  const Pose2& pose() const { return pose_; }

 private:
  Relocaliser& relocaliser_;
  const LocalMap& world_;
  Pose2 pose_;
  double time_s_ = 0.0;
};

Relocaliser makeRelocaliser() {
  return Relocaliser(RelocaliserConfig{}, vehicle(), Calibration{}, RandomGenerator(1));
}

TEST(HelicalRegion, SeesTheLandmarkWhereItWasObserved) {
  const Eigen::Vector2d landmark(3.0, -2.0), p_base_point(10.0, 4.0);
  for (const double heading : {-3.0, 0.0, 1.0, 2.5}) {
    const Pose2 pose = poseOnHelix(landmark, p_base_point, heading);
    EXPECT_NEAR((pose * p_base_point - landmark).norm(), 0.0, 1e-12);
    EXPECT_NEAR(pose.yaw_rad, heading, 1e-12);
  }
}

TEST(HelicalRegion, StaysWithinThePriorAndTheHeadings) {
  const LocalMap map = stand();
  const auto points = observedPoints(seenFrom({1.0, 1.0, 0.1}, map.landmarks, 0.0), 0.15);
  const DensityMap density(map.landmarks, points, 1000.0, {});
  RandomGenerator generator(1);
  const HelicalRegions regions{map.landmarks, points, {0.0, 0.2}, map.vehicle, 2.0};
  const ParticleSet particles = sampleHelicalRegions(regions, density, 3000, generator);
  ASSERT_EQ(particles.size(), 3000U);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const Eigen::Vector3d d = particles.pose(i).vector();
    EXPECT_LE(d.dot(map.vehicle.covariance.inverse() * d), 4.0 + 1e-3);
    EXPECT_LE(std::abs(d[2]), 0.2 + 1e-6);
  }
}

TEST(VisibleLandmarks, AreThoseThatSomeParticleMaySee) {
  const LocalMap map = stand();
  ParticleSet particles;
  particles.add({0.0, 0.0, 0.0});
  const std::vector<ObservedPoint> points{{Eigen::Vector2f(12.0F, 0.0F), 0.2, 12.0}};
  const auto idsOf = [&] {
    std::vector<int> ids;
    for (const auto& landmark : findVisibleLandmarks(particles, points, map.landmarks)) {
      ids.push_back(landmark.id);
    }
    return ids;
  };
  EXPECT_THAT(idsOf(), ElementsAre(0, 1));
  particles.add({60.0, 0.0, 0.0});
  EXPECT_THAT(idsOf(), ElementsAre(0, 1, 8, 9));
}

TEST(Relocaliser, FindsTheVehicleWithinThreeScans) {
  const LocalMap map = stand();
  Relocaliser relocaliser = makeRelocaliser();
  relocaliser.begin(map, 0.0);
  Drive drive(relocaliser, map, {1.5, -2.0, 0.08});
  std::optional<RelocaliserOutcome> outcome;
  for (int i = 0; i < 3; ++i) outcome = drive.scan();
  ASSERT_TRUE(outcome);
  EXPECT_LT((outcome->T_map_base.position() - drive.pose().position()).norm(), 0.1);
  EXPECT_FALSE(outcome->converged);
  EXPECT_THAT(outcome->doubt, HasSubstr("long enough"));
  for (int i = 0; i < 12 && !outcome->converged; ++i) outcome = drive.scan();
  EXPECT_TRUE(outcome->converged) << outcome->doubt;
  EXPECT_LT((outcome->T_map_base.position() - drive.pose().position()).norm(), 0.1);
}

TEST(Relocaliser, FindsTheVehicleWithoutAPrior) {
  const LocalMap map = stand();
  Relocaliser relocaliser = makeRelocaliser();
  relocaliser.beginGlobally(map, 0.0);
  Drive drive(relocaliser, map, {20.0, 1.0, 0.3});
  std::optional<RelocaliserOutcome> outcome;
  for (int i = 0; i < 4; ++i) outcome = drive.scan();
  ASSERT_TRUE(outcome);
  EXPECT_LT((outcome->T_map_base.position() - drive.pose().position()).norm(), 0.3);
}

TEST(Relocaliser, GivesTheSameBitsForTheSameSeed) {
  const LocalMap map = stand();
  const auto run = [&] {
    Relocaliser relocaliser = makeRelocaliser();
    relocaliser.begin(map, 0.0);
    Drive drive(relocaliser, map, {1.5, -2.0, 0.08});
    drive.scan();
    return drive.scan()->T_map_base.vector();
  };
  EXPECT_EQ(run(), run());
}

TEST(Relocaliser, NeverAcceptsAPlaceAmongLookAlikes) {
  const LocalMap map = avenue();
  Relocaliser relocaliser = makeRelocaliser();
  relocaliser.begin(map, 0.0);
  Drive drive(relocaliser, map, {1.0, 0.5, 0.05});
  for (int i = 0; i < 60; ++i) {
    const auto outcome = drive.scan();
    ASSERT_TRUE(outcome);
    EXPECT_FALSE(outcome->converged) << "scan " << i;
  }
}

TEST(Relocaliser, NeverAcceptsAPlaceThatDoesNotLookLikeTheMap) {
  LocalMap elsewhere = stand();
  for (LocalLandmark& landmark : elsewhere.landmarks) {
    landmark.position.y() = -landmark.position.y() + 1.7;
    landmark.position.x() = 1.1 * landmark.position.x() + 2.0;
  }
  Relocaliser relocaliser = makeRelocaliser();
  relocaliser.begin(stand(), 0.0);
  Drive drive(relocaliser, elsewhere, {0.0, 0.0, 0.0});
  for (int i = 0; i < 40; ++i) {
    const auto outcome = drive.scan();
    EXPECT_FALSE(outcome && outcome->converged) << "scan " << i;
  }
}

TEST(Relocaliser, StaysSilentBeforeItIsBegun) {
  Relocaliser relocaliser = makeRelocaliser();
  EXPECT_FALSE(relocaliser.process(seenFrom({}, stand().landmarks, 1.0)));
}

TEST(Relocaliser, WaitsForAScanThatShowsEnough) {
  Relocaliser relocaliser = makeRelocaliser();
  relocaliser.begin(stand(), 0.0);
  ObservationSet poor = seenFrom({}, stand().landmarks, 1.0);
  poor.observations.resize(2);
  EXPECT_FALSE(relocaliser.process(poor));
  EXPECT_EQ(relocaliser.counts().poor_scans, 1U);
  EXPECT_TRUE(relocaliser.process(seenFrom({}, stand().landmarks, 1.2)));
}

TEST(Relocaliser, SaysSoWhenNoPlaceExplainsTheScan) {
  LocalMap map = stand();
  map.vehicle.mean = {500.0, 500.0, 0.0};
  Relocaliser relocaliser = makeRelocaliser();
  relocaliser.begin(map, 0.0);
  const auto outcome = relocaliser.process(seenFrom({}, stand().landmarks, 1.0));
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->particles, 0U);
  EXPECT_THAT(outcome->doubt, HasSubstr("no particle"));
}

TEST(Relocaliser, RefusesScansAndMotionThatDoNotAdvance) {
  Relocaliser relocaliser = makeRelocaliser();
  relocaliser.begin(stand(), 0.0);
  EXPECT_TRUE(relocaliser.process(TwistInput{0.5, 1.0, 0.0, 0.0, std::nullopt}));
  EXPECT_FALSE(relocaliser.process(TwistInput{0.5, 1.0, 0.0, 0.0, std::nullopt}));
  EXPECT_FALSE(relocaliser.process(TwistInput{0.6, std::nan(""), 0.0, 0.0, std::nullopt}));
  EXPECT_TRUE(relocaliser.process(seenFrom({}, stand().landmarks, 1.0)));
  EXPECT_FALSE(relocaliser.process(seenFrom({}, stand().landmarks, 1.0)));
  EXPECT_EQ(relocaliser.counts().refused_motion, 2U);
  EXPECT_EQ(relocaliser.counts().refused_scans, 1U);
}

TEST(Relocaliser, LeavesOutObservationsThatAreNotFinite) {
  Relocaliser relocaliser = makeRelocaliser();
  relocaliser.begin(stand(), 0.0);
  ObservationSet set = seenFrom({}, stand().landmarks, 1.0);
  const std::size_t good = set.observations.size();
  set.observations.push_back(set.observations.front());
  set.observations.back().range_m = std::nan("");
  const auto outcome = relocaliser.process(set);
  ASSERT_TRUE(outcome);
  EXPECT_EQ(static_cast<std::size_t>(outcome->explanation.observations), good);
}

}  // namespace
}  // namespace hymm::core
