#include "cekf/path_closing.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "cekf/landmark_measurement.h"
#include "cekf/landmark_sighting.h"
#include "cekf/relinearisation.h"
#include "common/angles.h"
#include "common/chi_square.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr int kIterations = 5;

// Tells landmarks that the covariance ties to the vehicle's own, wrong place from those that it
// does not: at this probability, with deviations taken as often as the closing may take them.
constexpr double kTiedProbability = 0.9999;

// A second landmark has to be farther off than the nearest by this many times the plain distance.
constexpr double kClearance = 1.0;

/// The vehicle's states as the filter has them, but at another pose, within half a turn of its own.
VectorXd statesAt(const Pose2& T_map_base, const CompressedEkf& filter) {
  VectorXd states = filter.vehicle();
  states.head<2>() = T_map_base.position();
  states[2] += wrapAngle(T_map_base.yaw_rad - states[2]);
  return states;
}

/// Squared Mahalanobis distance of the joint innovation.
double jointDistance2(const std::vector<SparseMeasurement>& measurements,
                      const CompressedEkf& filter) {
  MatrixXd S = filter.innovationCovariance(measurements);
  VectorXd innovations(S.rows());
  for (Eigen::Index k = 0; k < S.rows(); k += 2) {
    const SparseMeasurement& measurement = measurements[static_cast<std::size_t>(k / 2)];
    S.block<2, 2>(k, k) += measurement.noise;
    innovations.segment<2>(k) = measurement.innovation;
  }
  const Eigen::LLT<MatrixXd> llt(S.selfadjointView<Eigen::Lower>());
  return llt.matrixL().solve(innovations).squaredNorm();
}

}  // namespace

PathClosing::PathClosing(const ResumptionConfig& config, bool at_first_estimates)
    : config_(config), at_first_estimates_(at_first_estimates) {}

/// The one landmark near where the observation lies, if it is alone there.
std::optional<PathClosing::Pair> PathClosing::tryPair(const Observation& observation,
                                                      const Pose2& T_map_base,
                                                      const SensorPlacement& sensor,
                                                      const LandmarkRegistry& registry,
                                                      CompressedEkf& filter) const {
  const Vector2d place =
      locateLandmark(T_map_base, sensor.T_base_sensor, observation.range_m - sensor.range_offset_m,
                     observation.bearing_rad)
          .position;
  const double clearance_m = kClearance * config_.plain_distance_m;
  std::optional<Pair> best;
  double second_m = config_.plain_distance_m + clearance_m;
  for (const int slot : registry.slotsNear(place, second_m)) {
    const RegisteredLandmark& landmark = registry.bySlot(slot);
    if (!mayBeOneKind(observation.type, landmark.type)) continue;
    std::optional<Pair> pair = pairWith(landmark, observation, T_map_base, sensor, filter);
    if (!pair) continue;
    pair->distance_m = (filter.landmark(slot) - place).norm();
    const bool is_nearest = pair->distance_m < (best ? best->distance_m : config_.plain_distance_m);
    if (is_nearest) std::swap(best, pair);
    if (pair) second_m = std::min(second_m, pair->distance_m);
  }
  if (best && second_m < best->distance_m + clearance_m) return std::nullopt;
  return best;
}

/// Nothing if the covariance ties the landmark to the vehicle's own, wrong place.
std::optional<PathClosing::Pair> PathClosing::pairWith(const RegisteredLandmark& landmark,
                                                       const Observation& observation,
                                                       const Pose2& T_map_base,
                                                       const SensorPlacement& sensor,
                                                       CompressedEkf& filter) const {
  Pair pair{observation, {}};
  pair.measurement = sightLandmark(pair.sighting, T_map_base, sensor, landmark, filter);
  const VectorXd vehicle_change = statesAt(T_map_base, filter) - filter.vehicle();
  Vector2d& innovation = pair.measurement.innovation;
  innovation += pair.measurement.H_vehicle * vehicle_change;
  const Matrix2d S =
      filter.innovationCovariance(pair.measurement, pair.measurement) + pair.measurement.noise;
  const double gate = config_.most_inflation * chiSquareQuantile(kTiedProbability, 2);
  if (innovation.dot(S.inverse() * innovation) > gate) return std::nullopt;
  return pair;
}

ScanAssociation PathClosing::associate(const ObservationSet& set, const Pose2& T_map_base,
                                       const VehicleState& vehicle,
                                       const LandmarkRegistry& registry,
                                       CompressedEkf& filter) const {
  const std::size_t n = set.observations.size();
  ScanAssociation result;
  result.slots.assign(n, ScanAssociation::kNone);
  result.claimed.assign(n, true);  // the scan that closes the loop makes no new landmarks
  result.ignored.assign(n, false);
  const SensorPlacement sensor = vehicle.placement(set.T_base_sensor, statesAt(T_map_base, filter));
  std::vector<std::optional<Pair>> pairs;
  for (const Observation& observation : set.observations) {
    pairs.push_back(tryPair(observation, T_map_base, sensor, registry, filter));
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!pairs[i]) continue;
    const int slot = pairs[i]->measurement.landmarks[0];
    const auto claims = std::count_if(pairs.begin(), pairs.end(), [&](const auto& pair) {
      return pair && pair->measurement.landmarks[0] == slot;
    });
    if (claims > 1) continue;
    result.slots[i] = slot;
    result.measurements.push_back(pairs[i]->measurement);
    result.sightings.push_back(pairs[i]->sighting);
  }
  return result;
}

/// z - h(x_i) - H_i * (x - x_i), for the vehicle's states x_i = `vehicle_at` and the landmarks
/// among the states `landmarks_at`, or where they are.
PathClosing::Measurements PathClosing::linearised(
    const ScanAssociation& association, const ObservationSet& set, const VectorXd& vehicle_at,
    const VectorXd* landmarks_at, const VehicleState& vehicle, const CompressedEkf& filter) const {
  const Pose2 pose = Pose2::fromVector(vehicle_at.head<3>());
  const SensorPlacement sensor = vehicle.placement(set.T_base_sensor, vehicle_at);
  const VectorXd vehicle_change = vehicle_at - filter.vehicle();
  Measurements result;
  for (std::size_t k = 0; k < association.measurements.size(); ++k) {
    const SparseMeasurement& before = association.measurements[k];
    const int slot = before.landmarks[0];
    const Vector2d landmark = filter.landmark(slot);
    const Vector2d at = landmarks_at ? filter.landmarkAmong(*landmarks_at, slot) : landmark;
    SparseMeasurement now = landmarkMeasurement(association.sightings[k], pose, sensor, {slot, at},
                                                filter.vehicleStates());
    now.dependAs(before);
    now.innovation += now.H_vehicle * vehicle_change + now.H_landmarks[0] * (at - landmark);
    result.push_back(now);
  }
  return result;
}

/// Lets the covariance belong to where linearised() takes the Jacobians.
void PathClosing::relineariseAt(const ScanAssociation& association, const VectorXd& vehicle_at,
                                const VectorXd* landmarks_at, VehicleState& vehicle,
                                LandmarkRegistry& registry, CompressedEkf& filter) const {
  if (!at_first_estimates_) return;
  relinearise(vehicle, vehicle_at.head<2>(), filter);
  for (const SparseMeasurement& measurement : association.measurements) {
    const int slot = measurement.landmarks[0];
    const Vector2d place =
        landmarks_at ? filter.landmarkAmong(*landmarks_at, slot) : filter.landmark(slot);
    relinearise(registry.bySlot(slot), place, filter);
  }
}

PathClosing::Measurements PathClosing::iterated(const ScanAssociation& association,
                                                const ObservationSet& set, const Pose2& T_map_base,
                                                VehicleState& vehicle, LandmarkRegistry& registry,
                                                CompressedEkf& filter) const {
  const VectorXd begin = statesAt(T_map_base, filter);
  relineariseAt(association, begin, nullptr, vehicle, registry, filter);
  Measurements measurements = linearised(association, set, begin, nullptr, vehicle, filter);
  for (int iteration = 1; iteration < kIterations; ++iteration) {
    const std::optional<VectorXd> states = filter.statesAfter(measurements);
    if (!states) break;
    const VectorXd at = states->head(filter.vehicleStates());
    relineariseAt(association, at, &*states, vehicle, registry, filter);
    measurements = linearised(association, set, at, &*states, vehicle, filter);
  }
  return measurements;
}

std::optional<PathClosing::Closing> PathClosing::tryClose(const ObservationSet& set,
                                                          const Pose2& T_map_base,
                                                          VehicleState& vehicle,
                                                          LandmarkRegistry& registry,
                                                          CompressedEkf& filter) const {
  Closing closing;
  closing.association = associate(set, T_map_base, vehicle, registry, filter);
  if (closing.pairs() < config_.least_pairs) return std::nullopt;
  closing.limit = chiSquareQuantile(config_.joint_probability, 2 * closing.pairs());
  const int states = filter.vehicleStates();
  const Eigen::Matrix3d P_pose = filter.vehicleCovariance().topLeftCorner<3, 3>();
  for (;;) {
    const Measurements measurements =
        iterated(closing.association, set, T_map_base, vehicle, registry, filter);
    closing.chi_square = jointDistance2(measurements, filter);
    if (closing.accepted()) {
      closing.association.measurements = measurements;
      closing.update = filter.update(measurements);
      break;
    }
    if (closing.inflation >= config_.most_inflation) break;
    const double before = closing.inflation;
    closing.inflation = std::min(3.0 * before, config_.most_inflation);
    MatrixXd Q = MatrixXd::Zero(states, states);
    Q.topLeftCorner<3, 3>() = (closing.inflation - before) * P_pose;
    filter.predict(filter.vehicle(), MatrixXd::Identity(states, states), Q);
  }
  return closing;
}

}  // namespace hymm::core
