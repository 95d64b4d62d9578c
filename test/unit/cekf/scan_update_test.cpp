#include "cekf/scan_update.h"

#include <cmath>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "cekf/landmark_measurement.h"
#include "cekf/observation_model.h"

namespace hymm::core {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

/// A vehicle that does not know its pose well, among landmarks of which it knows the places with a
/// given deviation, and what it sees of them: turned by some angle, and two metres ahead for each
/// radian.
class Turned {
 public:
  Turned(double true_yaw_rad, double landmark_deviation_m)
      : vehicle_(VehicleConfig{}, true, false), filter_(VectorXd::Zero(5), covariance()) {
    const Pose2 truth{2.0 * true_yaw_rad, 0.0, true_yaw_rad};
    set_.time_s = 1.0;
    for (const Vector2d& place : {Vector2d(10.0, 0.0), Vector2d(6.0, 6.0), Vector2d(5.0, -7.0)}) {
      const int slot =
          filter_.append(place, MatrixXd::Zero(2, 5),
                         landmark_deviation_m * landmark_deviation_m * Eigen::Matrix2d::Identity());
      Observation observation;
      const Vector2d z = predictRangeBearing(truth, Pose2{}, place).value;
      observation.range_m = z[0];
      observation.bearing_rad = z[1];
      observation.covariance = Vector2d(1e-4, 1e-6).asDiagonal();
      set_.observations.push_back(observation);
      RegisteredLandmark landmark;
      landmark.id = landmark.slot = slot;
      landmark.position = landmark.linearised_at = place;
      registry_.add(landmark);
      association_.slots.push_back(slot);
      association_.sightings.push_back(observation);
      association_.measurements.push_back(
          landmarkMeasurement(observation, Pose2{}, SensorPlacement{}, {slot, place}, 5));
    }
  }

  /// Error of the position after the update [m].
  double update(ScanUpdate& scan_update, double true_yaw_rad) {
    outcome_ = scan_update.update(set_, association_, vehicle_, registry_, filter_);
    return (filter_.vehicle().head<2>() - Vector2d(2.0 * true_yaw_rad, 0.0)).norm();
  }
  const UpdateOutcome& outcome() const { return outcome_; }
  const CompressedEkf& filter() const { return filter_; }

 private:
  static MatrixXd covariance() {
    VectorXd variances(5);
    variances << 0.25, 0.25, 0.25, 1e-6, 1e-6;
    return variances.asDiagonal();
  }

  VehicleState vehicle_;
  CompressedEkf filter_;
  LandmarkRegistry registry_;
  ObservationSet set_;
  ScanAssociation association_;
  UpdateOutcome outcome_;
};

TEST(ScanUpdate, RepeatsAnUpdateThatItsMeasurementsAreNotLinearOver) {
  constexpr double kYaw_rad = 0.5;
  ScanUpdate once(1), repeated(5);
  const double error_once = Turned(kYaw_rad, 0.01).update(once, kYaw_rad);
  const double error_repeated = Turned(kYaw_rad, 0.01).update(repeated, kYaw_rad);
  EXPECT_GT(error_once, 0.015);
  EXPECT_LT(error_repeated, 0.2 * error_once);
  EXPECT_EQ(once.iterated(), 0U);
  EXPECT_EQ(repeated.iterated(), 1U);
}

TEST(ScanUpdate, RepeatsNothingOverASmallCorrection) {
  constexpr double kYaw_rad = 1e-4;
  ScanUpdate once(1), repeated(5);
  const double error_once = Turned(kYaw_rad, 0.01).update(once, kYaw_rad);
  EXPECT_EQ(Turned(kYaw_rad, 0.01).update(repeated, kYaw_rad), error_once);
  EXPECT_EQ(repeated.iterated(), 0U);
}

TEST(ScanUpdate, RepeatsOnlyWhatMovesALandmarkFarIfToldSo) {
  constexpr double kYaw_rad = 0.5, kLeastMove_m = 0.5;
  ScanUpdate scan_update(5, kLeastMove_m);
  Turned sure(kYaw_rad, 0.01);
  sure.update(scan_update, kYaw_rad);
  EXPECT_LT(sure.outcome().largest_landmark_move_m, kLeastMove_m);
  EXPECT_EQ(scan_update.iterated(), 0U);
  Turned unsure(kYaw_rad, 3.0);
  unsure.update(scan_update, kYaw_rad);
  EXPECT_GT(unsure.outcome().largest_landmark_move_m, kLeastMove_m);
  EXPECT_EQ(scan_update.iterated(), 1U);
}

TEST(ScanUpdate, RefusesWhatLeadsAwayFromTheMeasurementsAndTakesItsLinearisationBack) {
  constexpr double kYaw_rad = 2.0;  // four deviations off
  ScanUpdate scan_update(3, 0.01);
  Turned turned(kYaw_rad, 1.0);
  const VectorXd vehicle = turned.filter().vehicle();
  const MatrixXd covariance = turned.filter().vehicleCovariance();
  turned.update(scan_update, kYaw_rad);
  EXPECT_TRUE(std::isnan(turned.outcome().nis));
  EXPECT_EQ(scan_update.diverged(), 1U);
  EXPECT_EQ(turned.filter().vehicle(), vehicle);
  EXPECT_LT((turned.filter().vehicleCovariance() - covariance).norm(), 1e-12);
}

TEST(ScanUpdate, RefusesWhatTheFilterRefuses) {
  ScanUpdate scan_update(5);
  Turned turned(0.5, 0.01);
  const double nan = std::nan("");
  turned.update(scan_update, 0.5);
  ASSERT_TRUE(std::isfinite(turned.outcome().nis));
  Turned broken(nan, 0.01);
  broken.update(scan_update, 0.5);
  EXPECT_TRUE(std::isnan(broken.outcome().nis));
}

}  // namespace
}  // namespace hymm::core
