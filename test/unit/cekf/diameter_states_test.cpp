#include "cekf/diameter_states.h"

#include <cmath>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "cekf/cekf_slam.h"
#include "cekf/observation_model.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr DiameterPrior kPrior{0.5, 0.3};

/// A trunk whose diameter is told as `diameter_m`, with the range to the centre hanging on it.
Observation seenAt(double range_m, double bearing_rad, double diameter_m, double deviation_m) {
  Observation observation;
  observation.type = LandmarkType::kTrunk;
  observation.range_m = range_m;
  observation.bearing_rad = bearing_rad;
  observation.diameter_m = diameter_m;
  observation.diameter_variance = deviation_m * deviation_m;
  observation.diameter_covariance << 0.5 * observation.diameter_variance, 0.0;
  observation.covariance << 0.25 * observation.diameter_variance + 1e-4, 0.0, 0.0, 1e-6;
  return observation;
}

CompressedEkf emptyFilter() { return {VectorXd::Zero(3), MatrixXd::Identity(3, 3)}; }

TEST(ConditionedOnDiameter, IsTheConditionalGaussian) {
  Matrix3d joint;  // of range, bearing, diameter
  joint << 4e-2, 1e-3, 5e-2, 1e-3, 2e-3, -3e-3, 5e-2, -3e-3, 9e-2;
  Observation observation;
  observation.range_m = 10.0;
  observation.bearing_rad = 0.2;
  observation.diameter_m = 0.6;
  observation.covariance = joint.topLeftCorner<2, 2>();
  observation.diameter_covariance = joint.topRightCorner<2, 1>();
  observation.diameter_variance = joint(2, 2);
  const Observation conditioned = conditionedOnDiameter(observation, 0.3);
  // Information form: conditioning takes rows and columns out of the inverse.
  const Matrix3d information = joint.inverse();
  const Matrix2d covariance = information.topLeftCorner<2, 2>().inverse();
  EXPECT_LT((conditioned.covariance - covariance).norm(), 1e-12);
  const Vector2d shift = -covariance * information.topRightCorner<2, 1>() * (0.3 - 0.6);
  EXPECT_NEAR(conditioned.range_m, 10.0 + shift[0], 1e-12);
  EXPECT_NEAR(conditioned.bearing_rad, 0.2 + shift[1], 1e-12);
}

TEST(DiameterStates, ShareASlotInPairs) {
  CompressedEkf filter = emptyFilter();
  DiameterStates diameters(kPrior);
  const Observation trunk = seenAt(10.0, 0.0, 0.4, 0.1);
  const DiameterState a = diameters.add(trunk, filter), b = diameters.add(trunk, filter);
  const DiameterState c = diameters.add(trunk, filter);
  EXPECT_EQ(a.slot, b.slot);
  EXPECT_NE(a.half, b.half);
  EXPECT_NE(c.slot, a.slot);
  EXPECT_EQ(filter.landmarkCount(), 0U);
}

TEST(DiameterStates, GiveTheirSlotBackWhenBothAreGone) {
  CompressedEkf filter = emptyFilter();
  DiameterStates diameters(kPrior);
  const Observation trunk = seenAt(10.0, 0.0, 0.4, 0.1);
  const DiameterState a = diameters.add(trunk, filter), b = diameters.add(trunk, filter);
  diameters.remove(a, filter);
  EXPECT_TRUE(filter.isActive(b.slot));
  diameters.remove(b, filter);
  EXPECT_FALSE(filter.isActive(b.slot));
}

TEST(DiameterStates, KeepASlotWhoseOtherHalfIsStillToBeGivenOut) {
  CompressedEkf filter = emptyFilter();
  DiameterStates diameters(kPrior);
  const Observation trunk = seenAt(10.0, 0.0, 0.4, 0.1);
  const DiameterState a = diameters.add(trunk, filter);
  diameters.remove(a, filter);
  const DiameterState b = diameters.add(trunk, filter);
  EXPECT_EQ(b.slot, a.slot);
  EXPECT_NE(b.half, a.half);
  diameters.remove(b, filter);
  EXPECT_FALSE(filter.isActive(b.slot));
}

TEST(DiameterStates, WeighTheFirstSightingAgainstThePrior) {
  CompressedEkf filter = emptyFilter();
  DiameterStates diameters(kPrior);
  const DiameterState state = diameters.add(seenAt(10.0, 0.0, 0.2, 0.3), filter);
  EXPECT_NEAR(DiameterStates::mean(state, filter), 0.35, 1e-12);
  EXPECT_NEAR(DiameterStates::variance(state, filter), 0.045, 1e-12);
}

TEST(DiameterStates, LearnFromBetterSightingsOnly) {
  CompressedEkf filter = emptyFilter();
  DiameterStates diameters(kPrior);
  const DiameterState state = diameters.add(seenAt(10.0, 0.0, 0.4, 0.1), filter);
  const double known = DiameterStates::variance(state, filter);
  for (int i = 0; i < 10; ++i) {
    DiameterStates::observe(seenAt(10.0, 0.0, 0.4, 0.1), state, filter);
  }
  EXPECT_EQ(DiameterStates::variance(state, filter), known);
  DiameterStates::observe(seenAt(3.0, 0.0, 0.3, 0.02), state, filter);
  EXPECT_LT(DiameterStates::variance(state, filter), 0.02 * 0.02);
  EXPECT_NEAR(DiameterStates::mean(state, filter), 0.3, 0.01);
}

/// The only landmark of a robot that stands still and sees it `sightings` times.
LandmarkEstimate trunkSeenFromOnePlace(int sightings, bool tells_diameter_covariance) {
  CekfSlam slam(CekfSlamConfig{}, VehicleConfig{});
  for (int i = 0; i < sightings; ++i) {
    slam.process(MotionInput{TwistInput{0.1 * i, 0.0, 0.0, 0.0}});
    ObservationSet set;
    set.time_s = 0.1 * i + 0.05;
    set.observations = {seenAt(10.0, 0.0, 0.4, 0.1)};
    if (!tells_diameter_covariance) set.observations[0].diameter_covariance.setZero();
    slam.process(set);
  }
  return slam.landmarkMap(0.0).landmarks.at(0);
}

TEST(CekfSlam, DoesNotAverageTheErrorOfADiameterAway) {
  const LandmarkEstimate naive = trunkSeenFromOnePlace(200, false);
  const LandmarkEstimate honest = trunkSeenFromOnePlace(200, true);
  EXPECT_LT(std::sqrt(naive.covariance(0, 0)), 0.02);
  // The diameter is known to 0.095 m of a first sighting and the prior; half of that in range.
  EXPECT_NEAR(std::sqrt(honest.covariance(0, 0)), 0.5 * 0.093, 0.003);
}

TEST(CekfSlam, FindsTheDiameterOfATrunkSeenFromAllSides) {
  // A robot goes round a circle of 10 m, among landmarks of known identity and without any width,
  // and round a trunk of 0.3 m that looks 0.5 m wide, and so 0.1 m too far away.
  const Vector2d trunk(2.0, 12.0);
  CekfSlam slam(CekfSlamConfig{}, VehicleConfig{});
  for (int step = 0; step <= 700; ++step) {
    const double time_s = 0.1 * step, angle = 0.1 * time_s;
    slam.process(MotionInput{TwistInput{time_s, 1.0, 0.0, 0.1}});
    const Pose2 T_map_base{10.0 * std::sin(angle), 10.0 - 10.0 * std::cos(angle), angle};
    ObservationSet set;
    set.time_s = time_s;
    for (int k = 0; k < 6; ++k) {
      const Vector2d post(15.0 * std::cos(k), 10.0 + 15.0 * std::sin(k));
      const Vector2d z = predictRangeBearing(T_map_base, Pose2{}, post).value;
      Observation observation;
      observation.range_m = z[0];
      observation.bearing_rad = z[1];
      observation.covariance = Vector2d(1e-4, 1e-6).asDiagonal();
      observation.identity = k;
      set.observations.push_back(observation);
    }
    const Vector2d z = predictRangeBearing(T_map_base, Pose2{}, trunk).value;
    set.observations.push_back(seenAt(z[0] + 0.1, z[1], 0.5, 0.2));
    set.observations.back().identity = 6;
    slam.process(set);
  }
  const LandmarkEstimate found = slam.landmarkMap(0.0).landmarks.at(6);
  EXPECT_NEAR(found.diameter_m, 0.3, 0.02);
  EXPECT_LT(std::sqrt(found.diameter_variance), 0.02);
  EXPECT_LT((found.position - trunk).norm(), 0.02);
}

}  // namespace
}  // namespace hymm::core
