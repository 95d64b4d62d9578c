// Every Jacobian of the filter's models against central differences at random places. Beside these:
// Arc and the calibration and pose Jacobians of MotionModel in test/unit/vehicle. (The derivatives
// inside the trunk fit are bounded on purpose where a beam grazes the edge; what they are for, the
// covariance of the fit, is tested by test/unit/perception/detector_consistency_test.cpp.)

#include <cmath>
#include <optional>
#include <variant>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include "cekf/gps_datum.h"
#include "cekf/observation_model.h"
#include "cekf/vehicle_state.h"
#include "simulation/simulation_config.h"
#include "support/any.h"
#include "support/numeric_jacobian.h"
#include "vehicle/motion_model.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using test::anyNumber;
using test::numericJacobian;

/// Heading away from where the angle jumps, since numeric differences would not know.
Pose2 anyPose() { return {anyNumber(-50.0, 50.0), anyNumber(-50.0, 50.0), anyNumber(-2.5, 2.5)}; }
Pose2 anySensor() { return {anyNumber(-4.0, 4.0), anyNumber(-1.0, 1.0), anyNumber(-0.3, 0.3)}; }

MotionInput anyInput() {
  if (*rc::gen::arbitrary<bool>()) {
    return AckermannInput{0.0, anyNumber(-5.0, 20.0), anyNumber(-0.6, 0.6)};
  }
  return TwistInput{0.0, anyNumber(-5.0, 20.0), anyNumber(-2.0, 2.0), anyNumber(-1.0, 1.0),
                    std::nullopt};
}

Calibration anyCalibration() {
  return {anyNumber(0.8, 1.2), anyNumber(0.8, 1.2), anyNumber(-0.05, 0.05)};
}

bool isNear(const MatrixXd& analytic, const MatrixXd& numeric) {
  return (analytic - numeric).norm() < 1e-7 * (1.0 + numeric.norm());
}

RC_GTEST_PROP(RangeBearing, HasItsJacobians, ()) {
  const Pose2 base = anyPose(), sensor = anySensor();
  const double range_m = anyNumber(0.5, 60.0), bearing = anyNumber(-3.0, 3.0);
  const Vector2d landmark =
      locateLandmark(base, sensor, range_m, bearing).position;  // not where bearings jump
  const RangeBearing z = predictRangeBearing(base, sensor, landmark);
  RC_ASSERT(isNear(z.H_pose,
                   numericJacobian(
                       [&](const VectorXd& p) -> VectorXd {
                         return predictRangeBearing(Pose2::fromVector(p), sensor, landmark).value;
                       },
                       base.vector())));
  RC_ASSERT(isNear(z.H_landmark, numericJacobian(
                                     [&](const VectorXd& l) -> VectorXd {
                                       return predictRangeBearing(base, sensor, l).value;
                                     },
                                     landmark)));
}

RC_GTEST_PROP(LocatedLandmark, HasItsJacobians, ()) {
  const Pose2 base = anyPose(), sensor = anySensor();
  const Vector2d z(anyNumber(0.5, 60.0), anyNumber(-3.0, 3.0));
  const LocatedLandmark located = locateLandmark(base, sensor, z[0], z[1]);
  RC_ASSERT(isNear(located.G_pose,
                   numericJacobian(
                       [&](const VectorXd& p) -> VectorXd {
                         return locateLandmark(Pose2::fromVector(p), sensor, z[0], z[1]).position;
                       },
                       base.vector())));
  RC_ASSERT(
      isNear(located.G_measurement, numericJacobian(
                                        [&](const VectorXd& m) -> VectorXd {
                                          return locateLandmark(base, sensor, m[0], m[1]).position;
                                        },
                                        z)));
}

RC_GTEST_PROP(MotionModel, HasTheErrorJacobiansOfVelocityAndStep, ()) {
  const MotionModel model(simulatedCar());
  const MotionInput input = anyInput();
  const Calibration calibration = anyCalibration();
  const Pose2 pose{anyNumber(-50.0, 50.0), anyNumber(-50.0, 50.0), anyNumber(-1.0, 1.0)};
  const double duration_s = anyNumber(0.001, 0.5);
  const Vector3d error(anyNumber(-2.0, 2.0), anyNumber(-2.0, 2.0), anyNumber(-2.0, 2.0));
  const MatrixXd of_velocity = numericJacobian(
      [&](const VectorXd& e) -> VectorXd {
        const BodyVelocity v = model.velocity(input, calibration, MotionError::fromVector(e));
        return Vector3d(v.forward_mps, v.lateral_mps, v.yaw_rate_radps);
      },
      error);
  RC_ASSERT(isNear(model.velocity(input, calibration, MotionError::fromVector(error)).J_error,
                   of_velocity));
  const MatrixXd of_step = numericJacobian(
      [&](const VectorXd& e) -> VectorXd {
        return model.step(pose, input, calibration, 0.0, duration_s, MotionError::fromVector(e))
            .pose.vector();
      },
      error);
  RC_ASSERT(isNear(
      model.step(pose, input, calibration, 0.0, duration_s, MotionError::fromVector(error)).J_error,
      of_step));
}

/// The vehicle's states after one step, from `state` of unit covariance, and the Jacobian that the
/// filter used: it is the covariance with landmarks that were copies of pairs of states.
struct MovedState {
  VectorXd state;
  MatrixXd J;
};

MovedState moved(const VehicleConfig& vehicle, const VectorXd& state, const MotionInput& input,
                 double duration_s) {
  VehicleState motion(vehicle, std::holds_alternative<TwistInput>(input), true);
  const int n = motion.size();
  CompressedEkf filter(state, MatrixXd::Identity(n, n));
  std::vector<int> copies;
  for (int i = 0; i < n; i += 2) {
    Eigen::Matrix<double, 2, Eigen::Dynamic> G = MatrixXd::Zero(2, n);
    G(0, i) = 1.0;
    if (i + 1 < n) G(1, i + 1) = 1.0;
    copies.push_back(filter.append(Vector2d::Zero(), G, Matrix2d::Identity()));
  }
  motion.takeInput(filter, input);
  motion.moveTo(filter, duration_s);
  MovedState result{filter.vehicle(), MatrixXd(n, n)};
  for (int i = 0; i < n; i += 2) {
    const auto columns = filter.vehicleLandmarkCovariance(copies[static_cast<std::size_t>(i / 2)]);
    result.J.col(i) = columns.col(0);
    if (i + 1 < n) result.J.col(i + 1) = columns.col(1);
  }
  return result;
}

RC_GTEST_PROP(VehicleState, CarriesCovariancesAlongByItsJacobian, ()) {
  const VehicleConfig vehicle = simulatedCar();
  const MotionInput input = anyInput();
  VehicleState motion(vehicle, std::holds_alternative<TwistInput>(input), true);
  VectorXd state = motion.initialState();
  state.head<3>() = Vector3d(anyNumber(-50.0, 50.0), anyNumber(-50.0, 50.0), anyNumber(-1.0, 1.0));
  state.segment<2>(3) = Vector2d(anyNumber(-2.0, 2.0), anyNumber(-2.0, 2.0));
  const double duration_s = anyNumber(0.001, 0.4);
  const MatrixXd numeric = numericJacobian(
      [&](const VectorXd& s) { return moved(vehicle, s, input, duration_s).state; }, state);
  RC_ASSERT(isNear(moved(vehicle, state, input, duration_s).J, numeric));
}

/// A filter whose states are those of a vehicle with a GPS datum, nothing known exactly.
class GpsJacobian {
 public:
  GpsJacobian() : vehicle_(simulatedCar(), true, true), n_(vehicle_.size()) {
    config_.enabled = true;
    config_.alignment_fixes = 3;
    config_.alignment_baseline_m = 10.0;
    VectorXd state = vehicle_.initialState();
    MatrixXd root = MatrixXd::Identity(n_, n_);
    for (Eigen::Index i = 0; i < root.size(); ++i) root(i) += anyNumber(-0.1, 0.1);
    P_ = 1e-2 * root * root.transpose();
    filter_.emplace(state, P_);
    datum_.emplace(config_, first());
    fix_.antenna = {anyNumber(-4.0, 4.0), anyNumber(-1.0, 1.0)};
    fix_.covariance = Vector2d(anyNumber(0.3, 1.0), anyNumber(0.3, 1.0)).asDiagonal();
  }

  int first() const { return vehicle_.gpsDatumIndex(); }

  /// Stands at `pose` and measures what the datum says, give or take `error`.
  bool takeFix(const Pose2& pose, const Vector2d& error) {
    VectorXd state = filter_->vehicle();
    state.head<3>() = pose.vector();
    filter_->predict(state, MatrixXd::Identity(n_, n_), MatrixXd::Zero(n_, n_));
    fix_.position = inverse(T_map_enu_) * (pose * fix_.antenna) + error;
    spread_.push_back(fix_.position);
    return datum_->process(fix_, *filter_).has_value();
  }

  VehicleState vehicle_;
  int n_;
  GpsConfig config_;
  MatrixXd P_;
  std::optional<CompressedEkf> filter_;
  std::optional<GpsDatum> datum_;
  Pose2 T_map_enu_ = anyPose();
  GpsFix fix_;
  std::vector<Vector2d> spread_;
};

RC_GTEST_PROP(GpsDatum, EntersTheStateWithTheCovarianceOfItsJacobians, ()) {
  GpsJacobian gps;
  gps.takeFix({0.0, 0.0, 0.2}, Vector2d::Zero());
  gps.takeFix({12.0, 3.0, -0.4}, Vector2d::Zero());
  const Pose2 pose{25.0, -4.0, anyNumber(-2.0, 2.0)};
  RC_ASSERT(gps.takeFix(pose, Vector2d::Zero()));
  const Vector3d datum = gps.filter_->vehicle().segment<3>(gps.first());
  RC_ASSERT((datum.head<2>() - gps.T_map_enu_.position()).norm() < 1e-9);
  RC_ASSERT(std::abs(wrapAngle(datum.z() - gps.T_map_enu_.yaw_rad)) < 1e-9);

  // The datum by pose, fix and yaw: T = antenna in the map - R(yaw) * fix.
  const auto datumOf = [&](const VectorXd& pose_fix_yaw) -> VectorXd {
    const Vector2d antenna = Pose2::fromVector(pose_fix_yaw.head<3>()) * gps.fix_.antenna;
    const Pose2 turn{0.0, 0.0, pose_fix_yaw[5]};
    const Vector2d place = antenna - turn.rotation() * pose_fix_yaw.segment<2>(3);
    return Vector3d(place.x(), place.y(), pose_fix_yaw[5]);
  };
  VectorXd inputs(6);
  inputs << pose.vector(), gps.fix_.position, datum.z();
  const MatrixXd J = numericJacobian(datumOf, inputs);
  Vector2d mean = Vector2d::Zero();
  for (const Vector2d& fix : gps.spread_) mean += fix / 3.0;
  double spread = 0.0;
  for (const Vector2d& fix : gps.spread_) spread += (fix - mean).squaredNorm();
  MatrixXd P = MatrixXd::Zero(6, 6);
  P.topLeftCorner<3, 3>() = gps.P_.topLeftCorner<3, 3>();
  P.block<2, 2>(3, 3) = gps.fix_.covariance;
  P(5, 5) = (gps.fix_.covariance.trace() / 2.0 + P(0, 0) + P(1, 1)) / spread;
  const MatrixXd after = gps.filter_->vehicleCovariance();
  RC_ASSERT(isNear(after.block(gps.first(), gps.first(), 3, 3), J * P * J.transpose()));
  RC_ASSERT(isNear(after.block(gps.first(), 0, 3, 3), (J * P).leftCols(3)));
}

RC_GTEST_PROP(GpsDatum, UpdatesTheStateByTheJacobianOfItsMeasurement, ()) {
  GpsJacobian gps;
  gps.takeFix({0.0, 0.0, 0.2}, Vector2d::Zero());
  gps.takeFix({12.0, 3.0, -0.4}, Vector2d::Zero());
  RC_PRE(gps.takeFix({25.0, -4.0, 0.1}, Vector2d::Zero()));
  const Pose2 pose{30.0, 10.0, anyNumber(-2.0, 2.0)};
  VectorXd before = gps.filter_->vehicle();
  before.head<3>() = pose.vector();
  const MatrixXd P = gps.filter_->vehicleCovariance();
  RC_ASSERT(gps.takeFix(pose, {anyNumber(-0.3, 0.3), anyNumber(-0.3, 0.3)}));

  const Vector2d fix = gps.fix_.position;
  const auto residualOf = [&](const VectorXd& state) -> VectorXd {
    return Pose2::fromVector(state.segment<3>(gps.first())) * fix -
           Pose2::fromVector(state.head<3>()) * gps.fix_.antenna;
  };
  const MatrixXd H = -numericJacobian(residualOf, before);
  const Matrix2d R = Pose2::fromVector(before.segment<3>(gps.first())).rotation();
  const Matrix2d S = H * P * H.transpose() + R * gps.fix_.covariance * R.transpose();
  const VectorXd expected = before + P * H.transpose() * S.inverse() * residualOf(before);
  RC_ASSERT(isNear(gps.filter_->vehicle(), expected));
}

}  // namespace
}  // namespace hymm::core
