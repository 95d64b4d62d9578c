// What the world may do to a search for the vehicle's place.

#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "tree_stand.h"

namespace hymm::core {
namespace {

/// A vehicle in a world that the search knows, which moves or stands.
class Drive {
 public:
  explicit Drive(Relocaliser& relocaliser) : relocaliser_(relocaliser) {}

  ObservationSet emptySet() const { return {time_s_, vehicle().laser.T_base_sensor(), {}}; }
  ObservationSet view() const { return seenFrom(pose_, stand().landmarks, time_s_); }
  void move(double speed_mps) {
    relocaliser_.process(TwistInput{time_s_, speed_mps, 0.0, 0.0, std::nullopt});
    time_s_ += kScanPeriod_s;
    pose_ = pose_ * Pose2{speed_mps * kScanPeriod_s, 0.0, 0.0};
  }
  void carryTo(const Pose2& pose) { pose_ = pose; }
  const Pose2& pose() const { return pose_; }

 private:
  Relocaliser& relocaliser_;
  Pose2 pose_{1.0, -1.0, 0.05};
  double time_s_ = 0.0;
};

Relocaliser begun(const LocalMap& map) {
  Relocaliser relocaliser(RelocaliserConfig{}, vehicle(), Calibration{}, RandomGenerator(1));
  relocaliser.begin(map, 0.0);
  return relocaliser;
}

TEST(RelocaliserInHostileWorlds, FindsItselfAgainAfterAMinuteWithoutLandmarks) {
  Relocaliser relocaliser = begun(stand());
  Drive drive(relocaliser);
  for (int i = 0; i < 5; ++i) {
    drive.move(4.0);
    relocaliser.process(drive.view());
  }
  for (double waited_s = 0.0; waited_s < 60.0; waited_s += kScanPeriod_s) {
    drive.move(0.0);
    const auto outcome = relocaliser.process(drive.emptySet());
    ASSERT_TRUE(outcome);
    ASSERT_FALSE(outcome->converged) << "after " << waited_s << " s";
    ASSERT_FALSE(outcome->doubt.empty());
    ASSERT_GT(outcome->particles, 0U);
    ASSERT_GT(outcome->effective_number, 0.0);
  }
  std::optional<RelocaliserOutcome> outcome;
  for (int i = 0; i < 3; ++i) {
    drive.move(4.0);
    outcome = relocaliser.process(drive.view());
  }
  EXPECT_LT((outcome->T_map_base.position() - drive.pose().position()).norm(), 0.3);
}

TEST(RelocaliserInHostileWorlds, BelievesNothingInAMapOfOneLandmark) {
  LocalMap map = stand();
  map.landmarks.resize(1);
  Relocaliser relocaliser = begun(map);
  Drive drive(relocaliser);
  for (int i = 0; i < 40; ++i) {
    drive.move(1.0);
    const auto outcome = relocaliser.process(drive.view());
    EXPECT_FALSE(outcome && outcome->converged) << "scan " << i;
  }
}

TEST(RelocaliserInHostileWorlds, SaysSoWhenAllParticlesAreInImpossiblePlaces) {
  Relocaliser relocaliser = begun(stand());
  Drive drive(relocaliser);
  for (int i = 0; i < 5; ++i) {
    drive.move(4.0);
    relocaliser.process(drive.view());
  }
  drive.carryTo({37.0, 3.0, -2.0});  // nobody told the encoders
  for (int i = 0; i < 20; ++i) {
    drive.move(1.0);
    const auto outcome = relocaliser.process(drive.view());
    ASSERT_TRUE(outcome);
    EXPECT_FALSE(outcome->converged) << "scan " << i;
    EXPECT_FALSE(outcome->doubt.empty());
    EXPECT_TRUE(outcome->T_map_base.vector().allFinite());
  }
}

TEST(RelocaliserInHostileWorlds, BelievesNoScansOfSpuriousReturnsOnly) {
  RandomGenerator generator(3);
  Relocaliser relocaliser = begun(stand());
  Drive drive(relocaliser);
  for (int i = 0; i < 60; ++i) {
    drive.move(4.0);
    ObservationSet set = drive.emptySet();
    for (int k = 0; k < 8; ++k) {
      const double range_m = sampleUniform(generator, 2.0, 25.0);
      set.observations.push_back(observed(range_m, sampleUniform(generator, -1.5, 1.5)));
    }
    const auto outcome = relocaliser.process(set);
    EXPECT_FALSE(outcome && outcome->converged) << "scan " << i;
  }
}

TEST(RelocaliserInHostileWorlds, TakesASetWithoutFiniteObservationsAsAnEmptyOne) {
  Relocaliser relocaliser = begun(stand());
  Drive drive(relocaliser);
  drive.move(4.0);
  ASSERT_TRUE(relocaliser.process(drive.view()));
  drive.move(4.0);
  ObservationSet set = drive.view();
  for (Observation& observation : set.observations) observation.bearing_rad = std::nan("");
  const auto outcome = relocaliser.process(set);
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->explanation.observations, 0);
  EXPECT_TRUE(outcome->covariance.allFinite());
}

}  // namespace
}  // namespace hymm::core
