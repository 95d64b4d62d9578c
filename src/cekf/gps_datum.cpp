#include "cekf/gps_datum.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "cekf/vehicle_state.h"
#include "common/chi_square.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;

Vector2d turnedLeft(const Vector2d& v) { return {-v.y(), v.x()}; }

}  // namespace

GpsDatum::GpsDatum(const GpsConfig& config, int first_state)
    : config_(config),
      first_state_(first_state),
      gate_(chiSquareQuantile(config.gate_probability, 2)) {}

std::optional<UpdateOutcome> GpsDatum::process(const GpsFix& fix, CompressedEkf& filter) {
  if (aligned_) return update(fix, filter);
  collect(fix, filter);
  if (samples_.size() < static_cast<std::size_t>(config_.alignment_fixes)) return std::nullopt;
  const Vector2d baseline = samples_.back().fix - samples_.front().fix;
  if (baseline.norm() < config_.alignment_baseline_m) return std::nullopt;
  align(fix, filter);
  return UpdateOutcome{};
}

void GpsDatum::collect(const GpsFix& fix, const CompressedEkf& filter) {
  samples_.push_back({VehicleState::pose(filter) * fix.antenna, fix.position});
}

void GpsDatum::align(const GpsFix& fix, CompressedEkf& filter) {
  Vector2d mean_map = Vector2d::Zero(), mean_fix = Vector2d::Zero();
  for (const Sample& sample : samples_) {
    mean_map += sample.antenna_map / static_cast<double>(samples_.size());
    mean_fix += sample.fix / static_cast<double>(samples_.size());
  }
  double dot = 0.0, cross = 0.0, spread = 0.0;
  for (const Sample& sample : samples_) {
    const Vector2d m = sample.antenna_map - mean_map, f = sample.fix - mean_fix;
    dot += f.dot(m);
    cross += f.x() * m.y() - f.y() * m.x();
    spread += f.squaredNorm();
  }
  const double yaw = std::atan2(cross, dot);

  // T_map_enu from the present pose and fix: t = antenna_map - R(yaw) * fix. The yaw's error is
  // that of the fixes over their spread, and of the vehicle's own drift while they were collected.
  const Pose2 pose = VehicleState::pose(filter);
  const Matrix2d R = Pose2{0.0, 0.0, yaw}.rotation();
  const Vector2d antenna = pose * fix.antenna;
  const Vector2d rotated = R * fix.position;
  const double sigma2 = noiseOf(fix).trace() / 2.0;
  const double drift2 = filter.vehicleCovariance().topLeftCorner<2, 2>().trace();
  const double yaw_variance = (sigma2 + drift2) / spread;

  MatrixXd G = MatrixXd::Zero(3, filter.vehicleStates());
  G.block<2, 2>(0, 0).setIdentity();
  G.block<2, 1>(0, 2) = turnedLeft(pose.rotation() * fix.antenna);
  Eigen::Matrix<double, 3, 3> J_noise = Eigen::Matrix3d::Zero();
  J_noise.topLeftCorner<2, 2>() = -R;
  J_noise.topRightCorner<2, 1>() = -turnedLeft(rotated);
  J_noise(2, 2) = 1.0;
  Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();
  noise.topLeftCorner<2, 2>() = noiseOf(fix);
  noise(2, 2) = yaw_variance;
  const Vector2d t = antenna - rotated;
  filter.initialiseVehicleStates(first_state_, Eigen::Vector3d(t.x(), t.y(), yaw), G,
                                 J_noise * noise * J_noise.transpose());
  aligned_ = true;
  samples_.clear();
}

std::optional<UpdateOutcome> GpsDatum::update(const GpsFix& fix, CompressedEkf& filter) const {
  const Pose2 pose = VehicleState::pose(filter);
  const Eigen::VectorXd state = filter.vehicle();
  const Pose2 T_map_enu = Pose2::fromVector(state.segment<3>(first_state_));
  const Vector2d rotated = T_map_enu.rotation() * fix.position;

  // Antenna in the map, once by the vehicle and once by the fix: their difference is the
  // innovation.
  SparseMeasurement measurement;
  measurement.innovation = T_map_enu.position() + rotated - pose * fix.antenna;
  measurement.H_vehicle.setZero(2, filter.vehicleStates());
  measurement.H_vehicle.leftCols<2>().setIdentity();
  measurement.H_vehicle.col(2) = turnedLeft(pose.rotation() * fix.antenna);
  measurement.H_vehicle.block<2, 2>(0, first_state_) = -Matrix2d::Identity();
  measurement.H_vehicle.col(first_state_ + 2) = -turnedLeft(rotated);
  const Matrix2d R = T_map_enu.rotation();
  measurement.noise = R * noiseOf(fix) * R.transpose();

  const Matrix2d S = filter.innovationCovariance(measurement, measurement) + measurement.noise;
  const double distance2 = measurement.innovation.dot(S.inverse() * measurement.innovation);
  if (!(distance2 <= gate_)) return std::nullopt;
  const UpdateOutcome outcome = filter.update({measurement});
  return std::isfinite(outcome.nis) ? std::optional(outcome) : std::nullopt;
}

Matrix2d GpsDatum::noiseOf(const GpsFix& fix) const {
  const double floor = config_.min_deviation_m * config_.min_deviation_m;
  Matrix2d noise = fix.covariance;
  noise(0, 0) = std::max(noise(0, 0), floor);
  noise(1, 1) = std::max(noise(1, 1), floor);
  return noise;
}

}  // namespace hymm::core
