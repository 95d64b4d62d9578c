#include "cekf/scan_associator.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "cekf/landmark_measurement.h"
#include "cekf/landmark_sighting.h"
#include "cekf/pairing_evidence.h"
#include "cekf/relinearisation.h"
#include "cekf/vehicle_state.h"
#include "common/chi_square.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// What a person would call the same object, whatever the covariances say.
constexpr double kSearchMargin_m = 0.5;

// Of a landmark that may be seen in any direction, no innovation is linear: it is no candidate.
constexpr double kMostBearingVariance = 1.0;

double largestDeviation(const Matrix2d& covariance) {
  return std::sqrt(std::max(covariance.trace(), 0.0));
}

/// Squared deviations between two diameters, 0 where one is unknown.
double diameterCost(const Observation& observation, const RegisteredLandmark& landmark,
                    double irregularity_m) {
  const double difference = observation.diameter_m - landmark.diameter_m;
  const double variance = observation.diameter_variance + landmark.diameter_variance +
                          2.0 * irregularity_m * irregularity_m;
  const double cost = difference * difference / variance;
  return std::isfinite(cost) ? cost : 0.0;
}

/// What further covariance of the vehicle's states does to a measurement.
Matrix2d covarianceFrom(const VehicleMatrix* more, const SparseMeasurement& measurement) {
  if (more == nullptr) return Matrix2d::Zero();
  const VehicleJacobian HP = measurement.H_vehicle.lazyProduct(*more);
  return HP.lazyProduct(measurement.H_vehicle.transpose());
}

/// The same of all, jointly.
Eigen::MatrixXd covarianceFrom(const VehicleMatrix& more,
                               const std::vector<SparseMeasurement>& measurements) {
  Eigen::MatrixXd H(2 * static_cast<Eigen::Index>(measurements.size()), more.cols());
  for (std::size_t k = 0; k < measurements.size(); ++k) {
    H.middleRows<2>(2 * static_cast<Eigen::Index>(k)) = measurements[k].H_vehicle;
  }
  return H * more * H.transpose();
}

}  // namespace

ScanAssociator::ScanAssociator(const AssociationConfig& config, std::optional<double> relinearise_m,
                               const LastingErrorConfig& lasting_errors)
    : config_(config),
      lasting_errors_(lasting_errors),
      relinearise_m_(relinearise_m),
      individual_gate_(chiSquareQuantile(config.individual_probability, 2)),
      wider_gate_(
          std::max(individual_gate_, chiSquareQuantile(config.new_landmark_probability, 2))),
      identity_gate_(chiSquareQuantile(config.identity_probability, 2)),
      least_log_odds_(-std::log(config.coincidence_probability)),
      rival_log_odds_(-std::log(config.rival_probability)),
      joint_({chiSquareQuantile(config.unpaired_probability, 2), config.joint_probability,
              config.max_nodes}) {}

SparseMeasurement ScanAssociator::measure(Observation& sighting, const SensorPlacement& sensor,
                                          RegisteredLandmark& landmark,
                                          CompressedEkf& filter) const {
  const Pose2 pose = VehicleState::pose(filter);
  SparseMeasurement measurement = sightLandmark(sighting, pose, sensor, landmark, filter);
  if (landmark.lasting_error.exists()) {
    lasting_errors_.goOn((pose * sensor.T_base_sensor).position(), landmark, filter);
    lasting_errors_.include(landmark.lasting_error, filter, sighting, measurement);
  }
  if (relinearise_m_) {
    const Vector2d place = filter.landmark(landmark.slot);
    if ((place - landmark.linearised_at).norm() > *relinearise_m_) {
      relinearise(landmark, place, filter);
    }
    linearise(measurement, pose, sensor, landmark.linearised_at, filter.vehicleStates());
  }
  return measurement;
}

/// Whether an object in the gate of innovation covariance `S` would hardly be another one.
bool ScanAssociator::isPlaceKnown(const Matrix2d& S, double chance_density) const {
  return logOdds(Pairing{0, 0, Vector2d::Zero(), 0.0, chance_density}, S) >= least_log_odds_;
}

ScanAssociation ScanAssociator::associate(const ObservationSet& set, const SensorPlacement& sensor,
                                          LandmarkRegistry& registry, CompressedEkf& filter,
                                          const VehicleMatrix* more) const {
  const std::size_t n = set.observations.size();
  ScanAssociation result;
  result.slots.assign(n, ScanAssociation::kNone);
  result.claimed.assign(n, false);
  result.ignored.assign(n, false);

  const bool has_identities =
      std::any_of(set.observations.begin(), set.observations.end(),
                  [](const Observation& observation) { return observation.identity >= 0; });
  if (has_identities) associateByIdentity(set, sensor, registry, filter, more, result);

  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < n; ++i) {
    if (set.observations[i].identity >= 0) continue;
    if (has_identities && !config_.use_unidentified) {
      result.ignored[i] = true;
      continue;
    }
    const auto compatible =
        compatibleLandmarks(set, sensor, static_cast<int>(i), registry, filter, more, result);
    if (compatible.size() >= 2) ++result.ambiguous;
    candidates.insert(candidates.end(), compatible.begin(), compatible.end());
  }
  if (config_.method == "nearest") {
    chooseNearest(candidates, result);
  } else if (!candidates.empty()) {
    chooseJointly(candidates, filter, more, result);
  }
  return result;
}

ScanAssociation ScanAssociator::associateAs(const std::vector<int>& slots,
                                            const ObservationSet& set,
                                            const SensorPlacement& sensor,
                                            LandmarkRegistry& registry,
                                            CompressedEkf& filter) const {
  ScanAssociation result = associateNothing(set);
  result.is_placed = true;
  result.slots = slots;
  for (std::size_t i = 0; i < slots.size(); ++i) {
    if (slots[i] == ScanAssociation::kNone) continue;
    Observation sighting = set.observations[i];
    result.measurements.push_back(measure(sighting, sensor, registry.bySlot(slots[i]), filter));
    result.sightings.push_back(sighting);
  }
  return result;
}

ScanAssociation ScanAssociator::associateNothing(const ObservationSet& set) {
  const std::size_t n = set.observations.size();
  ScanAssociation result;
  result.slots.assign(n, ScanAssociation::kNone);
  result.claimed.assign(n, true);
  result.ignored.assign(n, false);
  result.is_placed = false;
  return result;
}

void ScanAssociator::associateByIdentity(const ObservationSet& set, const SensorPlacement& sensor,
                                         LandmarkRegistry& registry, CompressedEkf& filter,
                                         const VehicleMatrix* more, ScanAssociation& result) const {
  for (std::size_t i = 0; i < set.observations.size(); ++i) {
    const Observation& observation = set.observations[i];
    if (observation.identity < 0) continue;
    RegisteredLandmark* landmark = registry.findIdentity(observation.identity);
    if (landmark == nullptr) continue;
    result.claimed[i] = true;
    Observation sighting = observation;
    const SparseMeasurement measurement = measure(sighting, sensor, *landmark, filter);
    const Matrix2d S = filter.innovationCovariance(measurement, measurement) + measurement.noise +
                       covarianceFrom(more, measurement);
    const bool seen_twice =
        std::find(result.slots.begin(), result.slots.end(), landmark->slot) != result.slots.end();
    if (seen_twice ||
        measurement.innovation.dot(S.inverse() * measurement.innovation) > identity_gate_) {
      continue;
    }
    result.slots[i] = landmark->slot;
    result.measurements.push_back(measurement);
    result.sightings.push_back(sighting);
    const double chance_density = config_.unmapped_density_per_m2 * observation.range_m;
    result.log_odds += logOdds(Pairing{0, 0, measurement.innovation, 0.0, chance_density}, S);
  }
}

ScanAssociator::SearchCircle ScanAssociator::searchCircle(const Observation& observation,
                                                          const SensorPlacement& sensor,
                                                          const CompressedEkf& filter,
                                                          const VehicleMatrix* more) const {
  const LocatedLandmark located =
      locateLandmark(VehicleState::pose(filter), sensor.T_base_sensor,
                     observation.range_m - sensor.range_offset_m, observation.bearing_rad);
  const auto G = vehicleJacobian(located, sensor, filter.vehicleStates());
  VehicleMatrix P = filter.vehicleCovariance();
  if (more != nullptr) P += *more;
  const VehicleJacobian GP = G.lazyProduct(P);
  const Matrix2d covariance = GP.lazyProduct(G.transpose()) + located.G_measurement *
                                                                  observation.covariance *
                                                                  located.G_measurement.transpose();
  return {located.position,
          kSearchMargin_m + std::sqrt(wider_gate_) * largestDeviation(covariance)};
}

// Where vehicle and landmarks share their uncertainty the nearest are the right ones. Where they do
// not, an observation with so many landmarks in its reach tells nothing about where it is.
std::vector<int> ScanAssociator::slotsIn(const SearchCircle& circle,
                                         const LandmarkRegistry& registry) const {
  // The deviation of a difference is at most the sum of both deviations.
  const double gate = std::sqrt(wider_gate_);
  const double reach_m = circle.own_reach_m + gate * registry.largestDeviation();
  const auto distance_m = [&](int slot) {
    return (registry.bySlot(slot).position - circle.centre).norm();
  };
  std::vector<int> slots = registry.slotsNear(circle.centre, reach_m);
  const auto is_outside = [&](int slot) {
    return distance_m(slot) > circle.own_reach_m + gate * registry.bySlot(slot).deviation_m;
  };
  slots.erase(std::remove_if(slots.begin(), slots.end(), is_outside), slots.end());
  if (slots.size() > kMaxConsidered) {
    const auto last = slots.begin() + static_cast<std::ptrdiff_t>(kMaxConsidered);
    std::nth_element(slots.begin(), last, slots.end(), [&](int a, int b) {
      return std::make_pair(distance_m(a), a) < std::make_pair(distance_m(b), b);
    });
    slots.erase(last, slots.end());
    std::sort(slots.begin(), slots.end());
  }
  return slots;
}

std::vector<ScanAssociator::Candidate> ScanAssociator::compatibleLandmarks(
    const ObservationSet& set, const SensorPlacement& sensor, int observation_index,
    LandmarkRegistry& registry, CompressedEkf& filter, const VehicleMatrix* more,
    ScanAssociation& result) const {
  const auto i = static_cast<std::size_t>(observation_index);
  const SearchCircle circle = searchCircle(set.observations[i], sensor, filter, more);
  std::vector<Candidate> candidates;
  for (const int slot : slotsIn(circle, registry)) {
    RegisteredLandmark& landmark = registry.bySlot(slot);
    bool is_claimed = false;
    if (std::find(result.slots.begin(), result.slots.end(), slot) != result.slots.end()) {
      is_claimed = true;  // by an observation that tells its identity
    } else if (auto found =
                   candidate(set.observations[i], sensor, landmark, filter, more, is_claimed)) {
      found->pairing.observation = observation_index;
      candidates.push_back(*found);
    }
    if (is_claimed) result.claimed[i] = true;
  }
  if (candidates.size() > kMaxCandidates) {
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const auto& a, const auto& b) { return a.distance2 < b.distance2; });
    candidates.resize(kMaxCandidates);
  }
  return candidates;
}

/// Nothing if the landmark is not compatible. `is_claimed`: whether it is so near that the
/// observation is of no new landmark.
std::optional<ScanAssociator::Candidate> ScanAssociator::candidate(
    const Observation& observation, const SensorPlacement& sensor, RegisteredLandmark& landmark,
    CompressedEkf& filter, const VehicleMatrix* more, bool& is_claimed) const {
  Candidate candidate;
  candidate.sighting = observation;
  candidate.measurement = measure(candidate.sighting, sensor, landmark, filter);
  const Matrix2d S = filter.innovationCovariance(candidate.measurement, candidate.measurement) +
                     candidate.measurement.noise + covarianceFrom(more, candidate.measurement);
  if (S(1, 1) > kMostBearingVariance) return std::nullopt;
  const Vector2d& innovation = candidate.measurement.innovation;
  candidate.distance2 = innovation.dot(S.inverse() * innovation);
  const double chance_density = config_.unmapped_density_per_m2 * observation.range_m;
  is_claimed = candidate.distance2 <= wider_gate_ && isPlaceKnown(S, chance_density);
  if (candidate.distance2 > individual_gate_) return std::nullopt;
  if (!mayBeOneKind(observation.type, landmark.type)) return std::nullopt;
  const double cue = config_.use_diameter
                         ? diameterCost(observation, landmark, config_.diameter_irregularity_m)
                         : 0.0;
  if (cue > joint_.limits().unpaired_cost) return std::nullopt;
  candidate.pairing = {0, landmark.slot, innovation, cue, chance_density};
  return candidate;
}

/// Nearest pairs first, each observation and each landmark once: what a filter does that looks at
/// one observation at a time.
void ScanAssociator::chooseNearest(const std::vector<Candidate>& candidates,
                                   ScanAssociation& result) const {
  std::vector<const Candidate*> ranked;
  for (const Candidate& candidate : candidates) ranked.push_back(&candidate);
  const auto cost = [](const Candidate* c) { return c->distance2 + c->pairing.cue_cost; };
  std::stable_sort(ranked.begin(), ranked.end(),
                   [&](const Candidate* a, const Candidate* b) { return cost(a) < cost(b); });
  std::vector<const Candidate*> chosen(result.slots.size(), nullptr);
  for (const Candidate* candidate : ranked) {
    const Candidate*& own = chosen[static_cast<std::size_t>(candidate->pairing.observation)];
    int& slot = result.slots[static_cast<std::size_t>(candidate->pairing.observation)];
    const bool taken = std::find(result.slots.begin(), result.slots.end(),
                                 candidate->pairing.landmark) != result.slots.end();
    if (slot != ScanAssociation::kNone || taken) continue;
    if (cost(candidate) > joint_.limits().unpaired_cost) continue;
    slot = candidate->pairing.landmark;
    own = candidate;
  }
  for (const Candidate* candidate : chosen) {
    if (candidate == nullptr) continue;
    result.measurements.push_back(candidate->measurement);
    result.sightings.push_back(candidate->sighting);
  }
}

void ScanAssociator::chooseJointly(const std::vector<Candidate>& candidates,
                                   const CompressedEkf& filter, const VehicleMatrix* more,
                                   ScanAssociation& result) const {
  const auto n = static_cast<Eigen::Index>(candidates.size());
  std::vector<Pairing> pairings;
  std::vector<SparseMeasurement> measurements;
  for (const Candidate& candidate : candidates) {
    pairings.push_back(candidate.pairing);
    measurements.push_back(candidate.measurement);
  }
  Eigen::MatrixXd S = filter.innovationCovariance(measurements);
  for (Eigen::Index k = 0; k < n; ++k) {
    S.block<2, 2>(2 * k, 2 * k) += measurements[static_cast<std::size_t>(k)].noise;
  }
  S = Eigen::MatrixXd(S.selfadjointView<Eigen::Lower>());
  if (more != nullptr) S += covarianceFrom(*more, measurements);
  const JointHypothesis best = joint_.find(pairings, S, static_cast<int>(result.slots.size()));
  result.complete = best.complete;
  const std::vector<int> undisputed =
      undisputedPairings(joint_, best.pairings, pairings, S, rival_log_odds_);
  const std::vector<int> proven = provenPairings(undisputed, pairings, S, least_log_odds_);
  result.log_odds += logOdds(proven, pairings, S);
  for (const int pairing : proven) {
    const Candidate& chosen = candidates[static_cast<std::size_t>(pairing)];
    const auto observation = static_cast<std::size_t>(chosen.pairing.observation);
    result.slots[observation] = chosen.pairing.landmark;
    result.measurements.push_back(chosen.measurement);
    result.sightings.push_back(chosen.sighting);
  }
}

}  // namespace hymm::core
