#include "cekf/vehicle_state.h"

#include <algorithm>
#include <cmath>

#include "vehicle/arc.h"

namespace hymm::core {

VehicleState::VehicleState(const VehicleConfig& vehicle, bool twist, bool with_gps_datum,
                           bool at_first_estimates, const MotionNoiseConfig& motion_noise)
    : model_(vehicle),
      earlier_readings_(vehicle.noise),
      hold_limit_s_(vehicle.noise.hold_limit_s),
      at_first_estimates_(at_first_estimates),
      noise_scale_(motion_noise) {
  const double relative =
      twist ? vehicle.noise.yaw_rate_deviation_relative : vehicle.noise.steering_deviation_relative;
  if (relative > 0.0) turn_relative_index_ = size_++;
  const CalibrationPrior& prior = vehicle.calibration;
  calibration_deviation_ = {
      prior.speed_scale_deviation, prior.turn_scale_deviation,
      twist ? prior.yaw_rate_offset_deviation_radps : prior.steering_offset_deviation_rad};
  for (std::size_t k = 0; k < 3; ++k) {
    if (calibration_deviation_[k] > 0.0) calibration_index_[k] = size_++;
  }
  laser_yaw_.deviation = prior.laser_yaw_deviation_rad;
  laser_range_.deviation = prior.laser_range_offset_deviation_m;
  laser_time_.deviation = prior.laser_time_offset_deviation_s;
  for (LaserError* error : {&laser_yaw_, &laser_range_, &laser_time_}) {
    if (error->deviation > 0.0) error->index = size_++;
  }
  if (with_gps_datum) {
    gps_datum_index_ = size_;
    size_ += 3;
  }
  beginMotionNoise();
}

Eigen::VectorXd VehicleState::initialState() const {
  Eigen::VectorXd state = Eigen::VectorXd::Zero(size_);
  const Eigen::Vector3d nominal = Calibration{}.vector();
  for (int k = 0; k < 3; ++k) {
    const int index = calibration_index_[static_cast<std::size_t>(k)];
    if (index >= 0) state[index] = nominal[k];
  }
  return state;
}

Eigen::MatrixXd VehicleState::initialCovariance() const {
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(size_, size_);
  covariance.block<2, 2>(kErrorIndex, kErrorIndex).setIdentity();
  if (turn_relative_index_ >= 0) covariance(turn_relative_index_, turn_relative_index_) = 1.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const int index = calibration_index_[k];
    if (index >= 0)
      covariance(index, index) = calibration_deviation_[k] * calibration_deviation_[k];
  }
  for (const LaserError& error : {laser_yaw_, laser_range_, laser_time_}) {
    if (error.index >= 0) covariance(error.index, error.index) = error.deviation * error.deviation;
  }
  return covariance;
}

SensorPlacement VehicleState::placement(const Pose2& T_base_sensor,
                                        const VehicleVector& state) const {
  SensorPlacement sensor;
  sensor.T_base_sensor = T_base_sensor;
  sensor.T_base_sensor.yaw_rad = wrapAngle(T_base_sensor.yaw_rad + laser_yaw_.valueIn(state));
  sensor.yaw_state = laser_yaw_.index;
  sensor.range_offset_m = laser_range_.valueIn(state);
  sensor.range_offset_state = laser_range_.index;
  if (laser_time_.index < 0) return sensor;

  const BodyVelocity v = model_.velocity(input_, calibration(state), motionError(state));
  const Eigen::Vector2d velocity(v.forward_mps, v.lateral_mps);
  const double dt = laser_time_.valueIn(state), turn = v.yaw_rate_radps * dt;
  const Eigen::Vector2d moved = Arc(turn).V() * velocity * dt;
  sensor.T_base_sensor = Pose2{moved.x(), moved.y(), turn} * sensor.T_base_sensor;
  sensor.time_offset_state = laser_time_.index;
  sensor.velocity << Pose2::fromVector(state.head<3>()).rotation() * velocity, v.yaw_rate_radps;
  return sensor;
}

SweepMotion VehicleState::motionFrom(const CompressedEkf& filter,
                                     const std::vector<MotionInput>& inputs) const {
  SweepMotion motion;
  if (!has_input_) return motion;
  const VehicleVector state = filter.vehicle();
  const Calibration calibration = this->calibration(state);
  const MotionError error = motionError(state);
  const Eigen::Vector3d times_s = model_.correlationTimes();
  const auto velocityAt = [&](const MotionInput& input, double after_s) {
    const Eigen::Array3d kept = (-after_s / times_s.array()).exp();  // see predict()
    return model_.velocity(
        input, calibration,
        {kept[0] * error.speed, kept[1] * error.turn, kept[2] * error.turn_relative});
  };
  const BodyVelocity first = velocityAt(input_, 0.0);
  motion.velocity_covariance = velocityCovariance(first, filter.vehicleCovariance());
  motion.white_density =
      noiseTimes().asDiagonal() * first.white_density * noiseTimes().asDiagonal();
  motion.pieces.push_back({0.0, first.forward_mps, first.lateral_mps, first.yaw_rate_radps});
  for (const MotionInput& input : inputs) {
    const double after_s = timeOf(input) - time_s_;
    if (after_s <= motion.pieces.back().from_s) continue;
    const BodyVelocity v = velocityAt(input, after_s);
    motion.pieces.push_back({after_s, v.forward_mps, v.lateral_mps, v.yaw_rate_radps});
  }
  return motion;
}

/// Of (forward, lateral, yaw rate), by what is known of calibration and errors.
Eigen::Matrix3d VehicleState::velocityCovariance(const BodyVelocity& velocity,
                                                 const VehicleMatrix& covariance) const {
  Eigen::Matrix3Xd J = Eigen::Matrix3Xd::Zero(3, size_);
  for (int k = 0; k < 3; ++k) {
    const int index = calibration_index_[static_cast<std::size_t>(k)];
    if (index >= 0) J.col(index) = velocity.J_calibration.col(k);
  }
  J.col(kErrorIndex) = velocity.J_error.col(0);
  J.col(kErrorIndex + 1) = velocity.J_error.col(1);
  if (turn_relative_index_ >= 0) J.col(turn_relative_index_) = velocity.J_error.col(2);
  return J * covariance * J.transpose();
}

LaserCalibration VehicleState::laserCalibration(const CompressedEkf& filter) const {
  const VehicleVector state = filter.vehicle();
  const VehicleMatrix covariance = filter.vehicleCovariance();
  LaserCalibration laser;
  Eigen::Index row = 0;
  for (const LaserError& error : {laser_yaw_, laser_range_, laser_time_}) {
    laser.mean[row] = error.valueIn(state);
    if (error.index >= 0) laser.deviation[row] = std::sqrt(covariance(error.index, error.index));
    ++row;
  }
  return laser;
}

Calibration VehicleState::calibration(const VehicleVector& state) const {
  Eigen::Vector3d values = Calibration{}.vector();
  for (int k = 0; k < 3; ++k) {
    const int index = calibration_index_[static_cast<std::size_t>(k)];
    if (index >= 0) values[k] = state[index];
  }
  return Calibration::fromVector(values);
}

MotionError VehicleState::motionError(const VehicleVector& state) const {
  return {state[kErrorIndex], state[kErrorIndex + 1],
          turn_relative_index_ >= 0 ? state[turn_relative_index_] : 0.0};
}

Eigen::Matrix3d VehicleState::calibrationCovariance(const VehicleMatrix& vehicle_covariance) const {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const int a = calibration_index_[static_cast<std::size_t>(i)];
      const int b = calibration_index_[static_cast<std::size_t>(j)];
      if (a >= 0 && b >= 0) covariance(i, j) = vehicle_covariance(a, b);
    }
  }
  return covariance;
}

bool VehicleState::takeInput(CompressedEkf& filter, const MotionInput& input) {
  const bool later = !has_input_ || timeOf(input) > timeOf(input_);
  if (!isFinite(input) || !later || timeOf(input) < time_s_) return false;
  moveTo(filter, timeOf(input));
  if (!has_input_) earlier_readings_.begin(input);
  input_ = input;
  has_input_ = true;
  in_gap_ = false;
  return true;
}

void VehicleState::moveTo(CompressedEkf& filter, double time_s) {
  if (!started_) {
    started_ = true;
    time_s_ = time_s;
    if (!has_input_) input_ = TwistInput{time_s, 0.0, 0.0, 0.0};
    return;
  }
  const double duration_s = time_s - time_s_;
  if (duration_s <= 0.0) return;
  const double age_s = time_s_ - timeOf(input_);
  if (!in_gap_ && age_s + duration_s > hold_limit_s_) {
    in_gap_ = true;
    ++gaps_;
  }
  predict(filter, age_s, duration_s);
  time_s_ = time_s;
}

/// Carries the filter along a step of motion whose input is `age_s` old when it begins.
void VehicleState::predict(CompressedEkf& filter, double age_s, double duration_s) {
  VehicleVector state = filter.vehicle();
  const MotionStep step =
      model_.step(Pose2::fromVector(state.head<3>()), input_, calibration(state), age_s, duration_s,
                  motionError(state), earlier_readings_.readings());
  if (has_input_) earlier_readings_.follow(input_, duration_s);
  const Pose2 corrected = Pose2::fromVector(state.head<3>());
  state.head<3>() = step.pose.vector();
  VehicleMatrix J = VehicleMatrix::Identity(size_, size_);
  J.topLeftCorner<3, 3>() = step.J_pose;
  if (at_first_estimates_) {
    const Eigen::Vector2d correction = corrected.position() - linearised_at_;
    J.block<2, 1>(0, 2) += Eigen::Vector2d(-correction.y(), correction.x());
  }
  linearised_at_ = step.pose.position();
  for (int k = 0; k < 3; ++k) {
    const int index = calibration_index_[static_cast<std::size_t>(k)];
    if (index >= 0) J.block<3, 1>(0, index) = step.J_calibration.col(k);
  }
  // The errors decay, and are renewed by as much; see addNoise().
  const Eigen::Vector3d times_s = model_.correlationTimes();
  const std::array<int, 3> errors{kErrorIndex, kErrorIndex + 1, turn_relative_index_};
  for (int k = 0; k < 3; ++k) {
    const int index = errors[static_cast<std::size_t>(k)];
    if (index < 0) continue;
    const double kept = std::exp(-duration_s / times_s[k]);
    state[index] *= kept;
    J.block<3, 1>(0, index) = step.J_error.col(k);
    J(index, index) = kept;
  }
  filter.predict(state, J, addNoise(step, J));
}

/// What the noise of a step adds to the covariance, which the account of it takes over as well.
VehicleMatrix VehicleState::addNoise(const MotionStep& step, const VehicleMatrix& J) {
  const Eigen::Vector3d times = noiseTimes();
  AccumulatedNoise::Parts added = errorVariances();
  const int n = std::min(size_, AccumulatedNoise::kStates);
  VehicleMatrix Q = VehicleMatrix::Zero(size_, size_);
  Q.topLeftCorner<3, 3>() = step.whiteNoise(times);
  for (AccumulatedNoise::Matrix& part : added) {
    for (Eigen::Index k = kErrorIndex; k < n; ++k) part(k, k) *= 1.0 - J(k, k) * J(k, k);
    Q.topLeftCorner(n, n) += part.topLeftCorner(n, n);
  }
  added[MotionNoiseScale::kTranslation].topLeftCorner<3, 3>() =
      step.whiteNoise({times[0], times[1], 0.0});
  added[MotionNoiseScale::kRotation].topLeftCorner<3, 3>() = step.whiteNoise({0.0, 0.0, times[2]});
  AccumulatedNoise::Matrix J_driven = AccumulatedNoise::Matrix::Identity();
  J_driven.topLeftCorner(n, n) = J.topLeftCorner(n, n);
  motion_noise_.carry(J_driven, added);
  return Q;
}

/// Of the errors of the motion, by what they are errors of, when nothing is known of them.
AccumulatedNoise::Parts VehicleState::errorVariances() const {
  AccumulatedNoise::Parts parts;
  for (AccumulatedNoise::Matrix& part : parts) part.setZero();
  const MotionNoiseScale::Factors& factors = noise_scale_.factors();
  constexpr auto kTranslation = MotionNoiseScale::kTranslation;
  constexpr auto kRotation = MotionNoiseScale::kRotation;
  parts[kTranslation](kErrorIndex, kErrorIndex) = factors[kTranslation];
  for (const int index : {kErrorIndex + 1, turn_relative_index_}) {
    if (index >= 0) parts[kRotation](index, index) = factors[kRotation];
  }
  return parts;
}

/// How many times as large as claimed deviations of (forward, lateral, yaw rate) are.
Eigen::Vector3d VehicleState::noiseTimes() const {
  const MotionNoiseScale::Factors times = noise_scale_.factors().cwiseSqrt();
  return {times[MotionNoiseScale::kTranslation], times[MotionNoiseScale::kTranslation],
          times[MotionNoiseScale::kRotation]};
}

void VehicleState::beginMotionNoise() { motion_noise_.begin(errorVariances()); }

void VehicleState::learnMotionNoise(const UpdateOutcome& update) {
  noise_scale_.learn(time_s_,
                     motion_noise_.evidence(update.vehicle_score, update.vehicle_information));
}

}  // namespace hymm::core
