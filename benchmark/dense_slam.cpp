#include "benchmark/dense_slam.h"

#include <cmath>

#include "cekf/observation_model.h"

namespace hymm::benchmarks {
namespace {

using core::Calibration;
using core::ObservationSet;
using core::Pose2;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// States: pose (x, y, yaw), errors (speed, turn), calibration (speed scale, turn scale, turn
// offset).
constexpr int kError = 3, kCalibration = 5, kStates = 8;

VectorXd initialState() {
  VectorXd state = VectorXd::Zero(kStates);
  state.tail<3>() = Calibration{}.vector();
  return state;
}

MatrixXd initialCovariance(const core::CalibrationPrior& prior) {
  VectorXd deviations = VectorXd::Zero(kStates);
  deviations.segment<2>(kError).setOnes();
  deviations.tail<3>() << prior.speed_scale_deviation, prior.turn_scale_deviation,
      prior.yaw_rate_offset_deviation_radps;
  return deviations.cwiseAbs2().asDiagonal();
}

}  // namespace

DenseSlam::DenseSlam(const core::VehicleConfig& vehicle, int landmarks)
    : model_(vehicle),
      filter_(initialState(), initialCovariance(vehicle.calibration), landmarks),
      input_(core::TwistInput{}) {}

void DenseSlam::process(const ScanPeriod& period) {
  for (const core::MotionInput& input : period.motion) {
    moveTo(timeOf(input));
    input_ = input;
  }
  moveTo(period.set.time_s);
  observe(period.set, period.identities);
}

void DenseSlam::moveTo(double time_s) {
  const double duration_s = started_ ? time_s - time_s_ : 0.0;
  started_ = true;
  if (duration_s > 0.0) {
    VectorXd state = filter_.vehicle();
    const core::MotionStep step =
        model_.step(pose(), input_, Calibration::fromVector(state.tail<3>()),
                    time_s_ - timeOf(input_), duration_s, {state[kError], state[kError + 1], 0.0});
    const Eigen::Array2d kept = (-duration_s / model_.correlationTimes().head<2>().array()).exp();
    MatrixXd J = MatrixXd::Identity(kStates, kStates), Q = MatrixXd::Zero(kStates, kStates);
    J.topLeftCorner<3, 3>() = step.J_pose;
    J.block<3, 2>(0, kError) = step.J_error.leftCols<2>();
    J.diagonal().segment<2>(kError) = kept;
    J.block<3, 3>(0, kCalibration) = step.J_calibration;
    Q.topLeftCorner<3, 3>() = step.whiteNoise(Eigen::Vector3d::Ones());
    Q.diagonal().segment<2>(kError) = 1.0 - kept.square();
    state.head<3>() = step.pose.vector();
    state.segment<2>(kError).array() *= kept;
    filter_.predict(state, J, Q);
  }
  time_s_ = time_s;
}

void DenseSlam::observe(const ObservationSet& set, const std::vector<int>& identities) {
  core::SensorPlacement sensor;
  sensor.T_base_sensor = set.T_base_sensor;
  std::vector<DenseEkf::Measurement> measurements;
  std::vector<std::size_t> fresh;
  for (std::size_t i = 0; i < identities.size(); ++i) {
    const auto known = landmark_of_identity_.find(identities[i]);
    if (known == landmark_of_identity_.end()) {
      fresh.push_back(i);
      continue;
    }
    const core::Observation& seen = set.observations[i];
    const core::RangeBearing z =
        core::predictRangeBearing(pose(), set.T_base_sensor, filter_.landmark(known->second));
    measurements.push_back(
        {{seen.range_m - z.value[0], core::wrapAngle(seen.bearing_rad - z.value[1])},
         core::vehicleJacobian(z, sensor, kStates),
         known->second,
         z.H_landmark,
         seen.covariance});
  }
  filter_.update(measurements);
  for (const std::size_t i : fresh) {
    const core::Observation& seen = set.observations[i];
    const core::LocatedLandmark located =
        core::locateLandmark(pose(), set.T_base_sensor, seen.range_m, seen.bearing_rad);
    landmark_of_identity_[identities[i]] =
        filter_.append(located.position, core::vehicleJacobian(located, sensor, kStates),
                       located.G_measurement * seen.covariance * located.G_measurement.transpose());
  }
}

}  // namespace hymm::benchmarks
