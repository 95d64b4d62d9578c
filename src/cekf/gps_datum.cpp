#include "cekf/gps_datum.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <Eigen/LU>

#include "cekf/vehicle_state.h"
#include "common/chi_square.h"
#include "common/quarter_turn.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;

// Bounds memory and work where a vehicle collects fixes for long before it drives.
constexpr std::size_t kMostSamples = 500;

}  // namespace

/// The rigid motion that takes fixes to where the antenna was in the map, by least squares.
class GpsDatum::Alignment {
 public:
  explicit Alignment(const std::vector<Sample>& samples) {
    const auto n = static_cast<double>(samples.size());
    for (const Sample& sample : samples) {
      mean_map_ += sample.antenna_map / n;
      mean_fix_ += sample.fix / n;
    }
    double dot = 0.0, cross = 0.0;
    for (const Sample& sample : samples) {
      const Vector2d m = sample.antenna_map - mean_map_, f = sample.fix - mean_fix_;
      dot += f.dot(m);
      cross += f.x() * m.y() - f.y() * m.x();
      spread_ += f.squaredNorm();
    }
    yaw_rad_ = std::atan2(cross, dot);
    R_ = Pose2{0.0, 0.0, yaw_rad_}.rotation();
  }

  double yaw() const { return yaw_rad_; }
  double spread() const { return spread_; }  ///< sum of the squared distances from the fixes' mean
  Vector2d residual(const Sample& sample) const {
    return sample.antenna_map - mean_map_ - R_ * (sample.fix - mean_fix_);
  }

 private:
  Vector2d mean_map_ = Vector2d::Zero(), mean_fix_ = Vector2d::Zero();
  double yaw_rad_ = 0.0, spread_ = 0.0;
  Matrix2d R_;
};

GpsDatum::GpsDatum(const GpsConfig& config, int first_state)
    : config_(config),
      first_state_(first_state),
      gate_(chiSquareQuantile(config.gate_probability, 2)) {}

std::optional<UpdateOutcome> GpsDatum::process(const GpsFix& fix, CompressedEkf& filter) {
  if (aligned_) {
    const std::optional<UpdateOutcome> outcome = update(fix, filter);
    noteOutcome(outcome.has_value());
    return outcome;
  }
  collect(fix, filter);
  if (!spansBaseline(samples_)) return std::nullopt;
  const std::optional<Turn> turn = agreedTurn();
  if (!turn) return std::nullopt;
  align(fix, *turn, filter);
  return UpdateOutcome{};
}

/// An alignment that refuses all fixes is wrong, and has changed nothing yet.
void GpsDatum::noteOutcome(bool used) {
  confirmed_ = confirmed_ || used;
  if (confirmed_ || ++refused_ < config_.alignment_fixes) return;
  aligned_ = false;
  refused_ = 0;
}

void GpsDatum::collect(const GpsFix& fix, const CompressedEkf& filter) {
  if (samples_.size() >= kMostSamples) {  // every other one, of those that are there, goes
    for (std::size_t i = 1; 2 * i < samples_.size(); ++i) samples_[i] = samples_[2 * i];
    samples_.resize((samples_.size() + 1) / 2);
  }
  const double drift2 = filter.vehicleCovariance().topLeftCorner<2, 2>().trace();
  samples_.push_back({VehicleState::pose(filter) * fix.antenna, fix.position,
                      noiseOf(fix).trace() / 2.0 + drift2});
}

/// Both by the fixes and in the map: a vehicle at rest whose GPS jumps has not travelled.
bool GpsDatum::spansBaseline(const std::vector<Sample>& samples) const {
  if (samples.size() < static_cast<std::size_t>(config_.alignment_fixes)) return false;
  const Sample &first = samples.front(), &last = samples.back();
  return (last.fix - first.fix).norm() >= config_.alignment_baseline_m &&
         (last.antenna_map - first.antenna_map).norm() >= config_.alignment_baseline_m;
}

/// The best turn (least squares) for the fixes that agree; those that agree least are left out one
/// by one. Nothing if too few are left, or the last is not among them: it places the map.
std::optional<GpsDatum::Turn> GpsDatum::agreedTurn() const {
  std::vector<Sample> agreeing = samples_;
  while (spansBaseline(agreeing) && 2 * agreeing.size() > samples_.size()) {
    const Alignment fit(agreeing);
    const auto disagreement = [&](const Sample& sample) {
      return fit.residual(sample).squaredNorm() / sample.variance;
    };
    const auto worst = std::max_element(
        agreeing.begin(), agreeing.end(),
        [&](const Sample& a, const Sample& b) { return disagreement(a) < disagreement(b); });
    // The yaw's error is that of the fixes over their spread, and of the vehicle's own drift while
    // they were collected.
    if (disagreement(*worst) <= gate_)
      return Turn{fit.yaw(), agreeing.back().variance / fit.spread()};
    if (std::next(worst) == agreeing.end()) return std::nullopt;
    agreeing.erase(worst);
  }
  return std::nullopt;
}

void GpsDatum::align(const GpsFix& fix, const Turn& turn, CompressedEkf& filter) {
  // T_map_enu from the present pose and fix: t = antenna_map - R(yaw) * fix.
  const Pose2 pose = VehicleState::pose(filter);
  const Matrix2d R = Pose2{0.0, 0.0, turn.yaw_rad}.rotation();
  const Vector2d antenna = pose * fix.antenna;
  const Vector2d rotated = R * fix.position;

  MatrixXd G = MatrixXd::Zero(3, filter.vehicleStates());
  G.block<2, 2>(0, 0).setIdentity();
  G.block<2, 1>(0, 2) = turnedLeft(pose.rotation() * fix.antenna);
  Eigen::Matrix<double, 3, 3> J_noise = Eigen::Matrix3d::Zero();
  J_noise.topLeftCorner<2, 2>() = -R;
  J_noise.topRightCorner<2, 1>() = -turnedLeft(rotated);
  J_noise(2, 2) = 1.0;
  Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();
  noise.topLeftCorner<2, 2>() = noiseOf(fix);
  noise(2, 2) = turn.variance;
  const Vector2d t = antenna - rotated;
  filter.initialiseVehicleStates(first_state_, Eigen::Vector3d(t.x(), t.y(), turn.yaw_rad), G,
                                 J_noise * noise * J_noise.transpose());
  aligned_ = true;
  confirmed_ = false;
  refused_ = 0;
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
