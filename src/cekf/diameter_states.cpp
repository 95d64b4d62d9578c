#include "cekf/diameter_states.h"

#include <cmath>

namespace hymm::core {

using Eigen::Matrix2d;
using Eigen::Vector2d;

namespace {

// Sightings of a diameter err alike, so one counts only if its variance is below this share of
// what is known. Were all errors the same, so many sightings would claim no more than
// 1 / (1 - share) times the information of the best.
constexpr double kWorthHaving = 0.25;

}  // namespace

bool dependsOnDiameter(const Observation& observation) {
  return std::isfinite(observation.diameter_m) && observation.diameter_variance > 0.0 &&
         !observation.diameter_covariance.isZero();
}

Vector2d diameterGain(const Observation& observation) {
  return observation.diameter_covariance / observation.diameter_variance;
}

Observation conditionedOnDiameter(Observation observation, double diameter_m) {
  const Vector2d gain = diameterGain(observation);
  const double error_m = observation.diameter_m - diameter_m;
  observation.range_m -= gain[0] * error_m;
  observation.bearing_rad -= gain[1] * error_m;
  observation.covariance -= gain * observation.diameter_covariance.transpose();
  return observation;
}

DiameterState DiameterStates::add(const Observation& first, CompressedEkf& filter) {
  if (!open_.exists()) {
    const Matrix2d variance = prior_.deviation_m * prior_.deviation_m * Matrix2d::Identity();
    open_ = {filter.appendQuantities(Vector2d::Constant(prior_.mean_m), variance), 0};
  }
  const DiameterState state = open_;
  open_ = state.half == 0 ? DiameterState{state.slot, 1} : DiameterState{};
  ++used_[state.slot];
  filter.activate(state.slot);
  update(first, state, filter);
  return state;
}

void DiameterStates::remove(const DiameterState& state, CompressedEkf& filter) {
  if (!state.exists() || --used_[state.slot] > 0 || open_.slot == state.slot) return;
  used_.erase(state.slot);
  filter.remove(state.slot);
}

void DiameterStates::clear() {
  open_ = {};
  used_.clear();
}

double DiameterStates::mean(const DiameterState& state, const CompressedEkf& filter) {
  return filter.landmark(state.slot)[state.half];
}

double DiameterStates::variance(const DiameterState& state, const CompressedEkf& filter) {
  return filter.covariance(state.slot, state.slot)(state.half, state.half);
}

void DiameterStates::observe(const Observation& sighting, const DiameterState& state,
                             CompressedEkf& filter) {
  if (!dependsOnDiameter(sighting)) return;
  if (sighting.diameter_variance > kWorthHaving * variance(state, filter)) return;
  update(sighting, state, filter);
}

void DiameterStates::update(const Observation& sighting, const DiameterState& state,
                            CompressedEkf& filter) {
  SparseMeasurement measurement;  // of one quantity: the second row says nothing
  measurement.innovation[0] = sighting.diameter_m - mean(state, filter);
  measurement.H_vehicle.resize(2, 0);
  measurement.landmarks[0] = state.slot;
  measurement.H_landmarks[0](0, state.half) = 1.0;
  measurement.noise(0, 0) = sighting.diameter_variance;
  filter.update({measurement});
}

}  // namespace hymm::core
