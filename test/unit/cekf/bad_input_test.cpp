// What no sensor should deliver and no world should hold: the filter's state stays valid, and
// health and counts say what happened.

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cekf/cekf_slam.h"
#include "cekf/compressed_ekf.h"
#include "common/gaussian.h"
#include "common/random.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// --- The filter's measurements -------------------------------------------------------------------

/// A vehicle of three states and one landmark, and a measurement of it.
struct OneLandmark {
  OneLandmark() : filter(VectorXd::Zero(3), MatrixXd::Identity(3, 3)) {
    slot = filter.append({5.0, 1.0}, MatrixXd::Identity(2, 3), 0.1 * Matrix2d::Identity());
    measurement.innovation << 0.1, -0.1;
    measurement.H_vehicle = -MatrixXd::Identity(2, 3);
    measurement.landmarks[0] = slot;
    measurement.H_landmarks[0] = Matrix2d::Identity();
    measurement.noise = 0.01 * Matrix2d::Identity();
  }

  void expectRefusal() {
    const VectorXd x = filter.vehicle();
    const MatrixXd P = filter.vehicleCovariance();
    const Vector2d landmark = filter.landmark(slot);
    const Matrix2d own = filter.covariance(slot, slot);
    EXPECT_TRUE(std::isnan(filter.update({measurement}).nis));
    EXPECT_EQ(filter.vehicle(), x);
    EXPECT_EQ(filter.vehicleCovariance(), P);
    EXPECT_EQ(filter.landmark(slot), landmark);
    EXPECT_EQ(filter.covariance(slot, slot), own);
  }

  CompressedEkf filter;
  int slot;
  SparseMeasurement measurement;
};

TEST(CompressedEkf, RefusesInnovationsThatAreNotFinite) {
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    OneLandmark one;
    one.measurement.innovation[1] = bad;
    one.expectRefusal();
  }
}

TEST(CompressedEkf, RefusesJacobiansThatAreNotFinite) {
  for (const double bad : {kNan, kInfinity}) {
    OneLandmark one;
    one.measurement.H_vehicle(0, 2) = bad;
    one.expectRefusal();
    OneLandmark other;
    other.measurement.H_landmarks[0](1, 0) = bad;
    other.expectRefusal();
  }
}

TEST(CompressedEkf, RefusesNoiseThatIsNotFinite) {
  for (const double bad : {kNan, kInfinity}) {
    for (int entry = 0; entry < 4; ++entry) {
      if (entry == 2) continue;  // above the diagonal, which nothing reads
      OneLandmark one;
      one.measurement.noise(entry % 2, entry / 2) = bad;
      one.expectRefusal();
    }
  }
}

TEST(CompressedEkf, RefusesSingularNoiseOfWhatIsKnownExactly) {
  CompressedEkf filter(VectorXd::Zero(3), MatrixXd::Zero(3, 3));
  SparseMeasurement exact;
  exact.H_vehicle = MatrixXd::Identity(2, 3);
  exact.noise = Matrix2d::Zero();
  EXPECT_TRUE(std::isnan(filter.update({exact}).nis));
  EXPECT_EQ(filter.vehicleCovariance(), MatrixXd::Zero(3, 3));
}

TEST(CompressedEkf, StaysValidUnderObservationsThatClaimToBeNearlyExact) {
  OneLandmark one;
  one.measurement.noise = 1e-14 * Matrix2d::Identity();
  one.measurement.innovation.setConstant(1e-8);
  for (int i = 0; i < 200; ++i) one.filter.update({one.measurement});
  MatrixXd P(5, 5);
  P.topLeftCorner(3, 3) = one.filter.vehicleCovariance();
  P.topRightCorner(3, 2) = one.filter.vehicleLandmarkCovariance(one.slot);
  P.bottomLeftCorner(2, 3) = P.topRightCorner(3, 2).transpose();
  P.bottomRightCorner(2, 2) = one.filter.covariance(one.slot, one.slot);
  EXPECT_TRUE(isSemiDefiniteCovariance(P));
  EXPECT_TRUE(one.filter.vehicle().allFinite());
}

TEST(CompressedEkf, RefusesToRemoveALandmarkThatIsNotThere) {
  OneLandmark one;
  EXPECT_THROW(one.filter.remove(one.slot + 1), std::invalid_argument);
  EXPECT_THROW(one.filter.remove(-1), std::invalid_argument);
  one.filter.remove(one.slot);
  EXPECT_THROW(one.filter.remove(one.slot), std::invalid_argument);
  EXPECT_EQ(one.filter.landmarkCount(), 0U);
}

// --- Observation sets
// ------------------------------------------------------------------------------

Observation seen(double range_m, double bearing_rad, int identity = -1) {
  Observation observation;
  observation.range_m = range_m;
  observation.bearing_rad = bearing_rad;
  observation.covariance = Vector2d(1e-3, 1e-5).asDiagonal();
  observation.identity = identity;
  return observation;
}

ObservationSet setOf(double time_s, std::vector<Observation> observations) {
  ObservationSet set;
  set.time_s = time_s;
  set.observations = std::move(observations);
  return set;
}

CekfSlam newSlam() {
  CekfSlamConfig config;
  config.motion_input = "odom";
  return CekfSlam(config, VehicleConfig{});
}

struct BadObservation {
  const char* name;
  Observation observation;
};

void PrintTo(const BadObservation& bad, std::ostream* stream) { *stream << bad.name; }

BadObservation withCovariance(const char* name, double rr, double rb, double br, double bb) {
  Observation observation = seen(5.0, 0.0);
  observation.covariance << rr, rb, br, bb;
  return {name, observation};
}

BadObservation withDiameter(const char* name, double diameter_m, double variance = 0.01,
                            double with_range = 0.0) {
  Observation observation = seen(5.0, 0.0);
  observation.diameter_m = diameter_m;
  observation.diameter_variance = variance;
  observation.diameter_covariance[0] = with_range;
  return {name, observation};
}

class BadObservationOf : public testing::TestWithParam<BadObservation> {};

TEST_P(BadObservationOf, IsRefusedAndCountedWhileTheOthersAreUsed) {
  CekfSlam slam = newSlam();
  for (int i = 0; i < 5; ++i) {
    slam.process(MotionInput{TwistInput{0.5 * i, 0.0, 0.0, 0.0, std::nullopt}});
    slam.process(setOf(0.5 * i + 0.1, {seen(8.0, 0.4)}));
  }
  ASSERT_EQ(slam.landmarkCount(), 1U);
  const auto outcome = slam.process(setOf(2.5, {GetParam().observation, seen(8.0, 0.4)}));
  ASSERT_TRUE(outcome && outcome->accepted);
  EXPECT_EQ(slam.counts().refused_observations, 1U);
  EXPECT_EQ(outcome->health.dof, 2);
  EXPECT_TRUE(slam.pose().covariance.allFinite());
}

INSTANTIATE_TEST_SUITE_P(
    CekfSlam, BadObservationOf,
    testing::Values(BadObservation{"RangeNan", seen(kNan, 0.0)},
                    BadObservation{"RangeInfinite", seen(kInfinity, 0.0)},
                    BadObservation{"RangeZero", seen(0.0, 0.0)},
                    BadObservation{"RangeNegative", seen(-3.0, 0.0)},
                    BadObservation{"BearingNan", seen(5.0, kNan)},
                    BadObservation{"BearingInfinite", seen(5.0, -kInfinity)},
                    withDiameter("DiameterNegative", -0.3),
                    withDiameter("DiameterInfinite", kInfinity),
                    withDiameter("DiameterVarianceNegative", 0.3, -0.01),
                    withDiameter("DiameterVarianceInfinite", 0.3, kInfinity),
                    withDiameter("DiameterCovarianceNan", 0.3, 0.01, kNan),
                    withDiameter("DiameterCovarianceTooLarge", 0.3, 0.01, 1.0),
                    withCovariance("CovarianceNan", kNan, 0.0, 0.0, 1e-5),
                    withCovariance("CovarianceInfinite", 1e-3, 0.0, 0.0, kInfinity),
                    withCovariance("CovarianceZero", 0.0, 0.0, 0.0, 0.0),
                    withCovariance("CovarianceSingular", 1e-4, 1e-4, 1e-4, 1e-4),
                    withCovariance("CovarianceNegative", 1e-3, 0.0, 0.0, -1e-5),
                    withCovariance("CovarianceAsymmetric", 1e-3, 5e-5, -5e-5, 1e-5)));

TEST(CekfSlam, TakesAnIdentityOnceFromASetThatHoldsItTwice) {
  CekfSlam slam = newSlam();
  slam.process(MotionInput{TwistInput{0.0, 0.0, 0.0, 0.0, std::nullopt}});
  slam.process(setOf(0.1, {seen(8.0, 0.4, 7), seen(12.0, -0.4, 7)}));
  EXPECT_EQ(slam.landmarkCount(), 1U);
  const auto outcome = slam.process(setOf(0.3, {seen(8.0, 0.4, 7), seen(8.0, 0.4, 7)}));
  EXPECT_EQ(outcome->health.dof, 2);
  EXPECT_EQ(slam.landmarkCount(), 1U);
  EXPECT_EQ(outcome->associations[0].landmark_id, 0);
  EXPECT_EQ(outcome->associations[1].landmark_id, Association::kRejected);
}

// --- Worlds
// ------------------------------------------------------------------------------------------

/// A robot that drives along x among landmarks and sees all of them ahead within 25 m.
class Drive {
 public:
  Drive(CekfSlam& slam, std::vector<Vector2d> landmarks)
      : slam_(slam), landmarks_(std::move(landmarks)) {}

  /// One metre on, and a scan.
  ScanOutcome step() {
    for (int i = 0; i < 5; ++i) {
      slam_.process(MotionInput{TwistInput{time_s_, 5.0, 0.0, 0.0, std::nullopt}});
      time_s_ += 0.04;
      place_.x() += 0.2;
    }
    std::vector<Observation> observations;
    for (const Vector2d& landmark : landmarks_) {
      const Vector2d d = landmark - place_;
      if (d.norm() > 25.0 || d.x() < 0.0) continue;
      observations.push_back(seen(d.norm() + sampleNormal(generator_, 0.03),
                                  std::atan2(d.y(), d.x()) + sampleNormal(generator_, 0.003)));
    }
    return *slam_.process(setOf(time_s_, std::move(observations)));
  }

  /// Puts the robot elsewhere, without its odometry noticing.
  void teleport(const Vector2d& by) { place_ += by; }
  const Vector2d& place() const { return place_; }

 private:
  CekfSlam& slam_;
  std::vector<Vector2d> landmarks_;
  RandomGenerator generator_{1};
  Vector2d place_ = Vector2d::Zero();
  double time_s_ = 0.0;
};

std::vector<Vector2d> randomPlaces(int count, const Vector2d& low, const Vector2d& high) {
  RandomGenerator generator(2);
  std::vector<Vector2d> places;
  for (int i = 0; i < count; ++i) {
    places.emplace_back(sampleUniform(generator, low.x(), high.x()),
                        sampleUniform(generator, low.y(), high.y()));
  }
  return places;
}

TEST(CekfSlam, SaysSoWhenTheVehicleTeleportsAndKeepsItsMap) {
  CekfSlam slam = newSlam();
  Drive drive(slam, randomPlaces(300, {0.0, -60.0}, {250.0, 60.0}));
  for (int i = 0; i < 60; ++i) {
    const FilterHealth health = drive.step().health;
    if (i < 30) continue;  // until there is a map
    ASSERT_GT(health.dof, 0) << i;
    ASSERT_LT(health.unexplained, 0.8) << i;
  }
  const LandmarkMap before = slam.landmarkMap(0.0);
  drive.teleport({13.0, 31.0});
  for (int i = 0; i < 5; ++i) {
    const ScanOutcome outcome = drive.step();
    EXPECT_GT(outcome.health.unexplained, 0.8);
    EXPECT_TRUE(isSemiDefiniteCovariance(outcome.pose.covariance));
  }
  const LandmarkMap after = slam.landmarkMap(0.0);
  for (std::size_t i = 0; i < before.landmarks.size(); ++i) {
    EXPECT_TRUE(isCovariance(after.landmarks[i].covariance));
  }
}

TEST(CekfSlam, DrivesThroughAreasWithoutALandmark) {
  CekfSlam slam = newSlam();
  Drive drive(slam, {{15.0, 5.0}, {18.0, -4.0}, {22.0, 6.0}});
  for (int i = 0; i < 300; ++i) drive.step();
  EXPECT_EQ(slam.landmarkCount(), 3U);
  EXPECT_GE(slam.counts().area_switches, 9U);
  EXPECT_TRUE(isSemiDefiniteCovariance(slam.pose().covariance));
  EXPECT_NEAR(slam.pose().T_map_base.x_m, drive.place().x(), 10.0);
}

TEST(CekfSlam, StartsWithAreasWithoutALandmark) {
  CekfSlam slam = newSlam();
  Drive drive(slam, {{240.0, 5.0}, {245.0, -4.0}});
  for (int i = 0; i < 250; ++i) drive.step();
  EXPECT_EQ(slam.landmarkCount(), 2U);
  EXPECT_GE(slam.counts().area_switches, 7U);
}

TEST(CekfSlam, BoundsItsWorkInAWorldThatIsTooDenseAndSaysSo) {
  CekfSlam slam = newSlam();
  Drive drive(slam, randomPlaces(600, {0.0, -30.0}, {40.0, 30.0}));  // 25 on 100 m^2
  std::size_t observations = 0;
  for (int i = 0; i < 6; ++i) observations += drive.step().observations.observations.size();
  EXPECT_GT(observations, 6U * 150U);
  EXPECT_GT(slam.counts().bounded_associations, 0U);
  EXPECT_GT(slam.counts().associated, observations / 4);
  EXPECT_TRUE(isSemiDefiniteCovariance(slam.pose().covariance));
  EXPECT_LT((slam.pose().T_map_base.position() - drive.place()).norm(), 0.5);
}

}  // namespace
}  // namespace hymm::core
