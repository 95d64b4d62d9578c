#include "cekf/landmark_life_cycle.h"

#include <algorithm>
#include <cmath>

#include "cekf/landmark_visibility.h"
#include "cekf/observation_model.h"
#include "cekf/vehicle_state.h"
#include "common/chi_square.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Landmarks nearer than this are worth remembering as distinct when one scan shows both.
constexpr double kNeighbourhood_m = 2.0;

// Existence never becomes so certain that a felled tree could not be dropped.
constexpr double kLargestLogOdds = 5.0;

// Moves that nobody needs to hear of.
constexpr double kNoticeableMove_m = 1e-3;

/// Any diameter that a trunk may have is as likely as any other.
DiameterPrior diameterPrior(const TrunkConfig& trunks) {
  return {0.5 * (trunks.min_diameter_m + trunks.max_diameter_m),
          (trunks.max_diameter_m - trunks.min_diameter_m) / std::sqrt(12.0)};
}

void fuseDiameter(const Observation& observation, RegisteredLandmark& landmark) {
  if (!std::isfinite(observation.diameter_m) || !(observation.diameter_variance > 0.0)) return;
  if (!std::isfinite(landmark.diameter_m)) {
    landmark.diameter_m = observation.diameter_m;
    landmark.diameter_variance = observation.diameter_variance;
    return;
  }
  const double gain =
      landmark.diameter_variance / (landmark.diameter_variance + observation.diameter_variance);
  landmark.diameter_m += gain * (observation.diameter_m - landmark.diameter_m);
  landmark.diameter_variance *= 1.0 - gain;
}

}  // namespace

LandmarkLifeCycle::LandmarkLifeCycle(const CekfSlamConfig& config)
    : config_(config.landmarks),
      large_correction_m_(config.large_correction_m),
      at_first_estimates_(config.update.atFirstEstimates()),
      merge_gate_(chiSquareQuantile(config_.merge_probability, 2)),
      hit_log_odds_(std::log(config_.detection_probability / config_.false_detection_probability)),
      miss_log_odds_(std::log((1.0 - config_.detection_probability) /
                              (1.0 - config_.false_detection_probability))),
      diameters_(diameterPrior(config.perception.trunks)),
      lasting_error_model_(config.lasting_errors),
      tentative_({config_.promote_sightings, config_.promote_share, config_.promote_span_s}),
      duplicate_search_(config_, config.association, config.slip) {}

void LandmarkLifeCycle::confirm(const ObservationSet& set, const ScanAssociation& association,
                                CompressedEkf& filter) {
  ++scan_number_;
  for (std::size_t i = 0; i < association.slots.size(); ++i) {
    if (association.slots[i] == ScanAssociation::kNone) continue;
    RegisteredLandmark& landmark = registry_.bySlot(association.slots[i]);
    const Observation& observation = set.observations[i];
    ++landmark.observations;
    landmark.last_seen_s = set.time_s;
    landmark.farthest_seen_m = std::max(landmark.farthest_seen_m, observation.range_m);
    landmark.existence_log_odds =
        std::min(landmark.existence_log_odds + hit_log_odds_, kLargestLogOdds);
    if (landmark.type == LandmarkType::kUnknown) landmark.type = observation.type;
    if (isConfirmed(landmark)) unconfirmed_ids_.erase(landmark.id);
    if (landmark.diameter_state.exists()) {
      DiameterStates::observe(observation, landmark.diameter_state, filter);
    } else {
      fuseDiameter(observation, landmark);
    }
  }
  noteNeighboursSeenTogether(association.slots);
}

void LandmarkLifeCycle::noteNeighboursSeenTogether(const std::vector<int>& slots) {
  for (std::size_t i = 0; i < slots.size(); ++i) {
    if (slots[i] == ScanAssociation::kNone) continue;
    const RegisteredLandmark& a = registry_.bySlot(slots[i]);
    for (std::size_t j = i + 1; j < slots.size(); ++j) {
      if (slots[j] == ScanAssociation::kNone) continue;
      const RegisteredLandmark& b = registry_.bySlot(slots[j]);
      if ((a.position - b.position).norm() > kNeighbourhood_m) continue;
      distinct_from_[a.id].insert(b.id);
      distinct_from_[b.id].insert(a.id);
    }
  }
}

LandmarkLifeCycle::Missed LandmarkLifeCycle::miss(const LaserScan& scan, const ObservationSet& set,
                                                  const SensorPlacement& sensor,
                                                  const ScanAssociation& association,
                                                  CompressedEkf& filter) {
  const Pose2 T_map_sensor = VehicleState::pose(filter) * sensor.T_base_sensor;
  const Pose2 T_sensor_map = inverse(T_map_sensor);
  Missed missed;
  for (const int slot : registry_.slotsNear(T_map_sensor.position(), config_.visible_range_m)) {
    const auto& seen = association.slots;
    if (std::find(seen.begin(), seen.end(), slot) != seen.end()) continue;
    RegisteredLandmark& landmark = registry_.bySlot(slot);
    if (landmark.last_seen_s >= set.time_s) continue;
    if (!shouldBeVisible(scan, T_sensor_map * landmark.position, landmark, config_)) continue;
    if (!isPlaceKnown(landmark, filter)) continue;
    ++missed.all;
    if (isConfirmed(landmark)) ++missed.confirmed;
    landmark.existence_log_odds += miss_log_odds_;
    if (landmark.existence_log_odds >= config_.drop_log_odds) continue;
    if (pinned_ids_.count(landmark.id) > 0) {
      landmark.existence_log_odds = config_.drop_log_odds;  // so that it is soon believed again
    } else {
      drop(landmark.id, filter);
      ++counts_.dropped;
    }
  }
  return missed;
}

/// Whether it is known where in the scan the landmark should be, to the separation of landmarks.
bool LandmarkLifeCycle::isPlaceKnown(const RegisteredLandmark& landmark,
                                     const CompressedEkf& filter) const {
  const Pose2 pose = VehicleState::pose(filter);
  const Vector2d arm = landmark.position - pose.position();
  Eigen::Matrix<double, 2, 3> H;  // of the landmark's place relative to the vehicle's, by the pose
  H << -1.0, 0.0, arm.y(), 0.0, -1.0, -arm.x();
  const Eigen::Matrix<double, 3, 2> cross =
      filter.vehicleLandmarkCovariance(landmark.slot).topRows<3>();
  const Matrix2d covariance = H * filter.vehicleCovariance().topLeftCorner<3, 3>() * H.transpose() +
                              H * cross + (H * cross).transpose() +
                              filter.covariance(landmark.slot, landmark.slot);
  return covariance.trace() < config_.min_separation_m * config_.min_separation_m;
}

void LandmarkLifeCycle::pin(const std::unordered_set<int>& ids) {
  if (ids == told_pins_) return;
  told_pins_ = ids;
  followMerges();
}

void LandmarkLifeCycle::followMerges() {
  pinned_ids_ = told_pins_;
  for (const LandmarkMerge& merge : merges_) {  // in the order in which they happened
    if (pinned_ids_.erase(merge.from_id) > 0) pinned_ids_.insert(merge.into_id);
  }
}

void LandmarkLifeCycle::dropUnconfirmed(double time_s, CompressedEkf& filter) {
  const std::set<int> unconfirmed_ids = unconfirmed_ids_;
  for (const int id : unconfirmed_ids) {
    if (time_s - registry_.byId(id).last_seen_s < config_.unconfirmed_life_s) continue;
    if (pinned_ids_.count(id) > 0) continue;
    drop(id, filter);
    ++counts_.dropped;
  }
}

void LandmarkLifeCycle::drop(int id, CompressedEkf& filter) {
  filter.remove(registry_.byId(id).slot);
  diameters_.remove(registry_.byId(id).diameter_state, filter);
  lasting_errors_.remove(registry_.byId(id), filter);
  registry_.remove(id);
  if (const auto known = distinct_from_.extract(id)) {
    for (const int other : known.mapped()) distinct_from_[other].erase(id);
  }
  unconfirmed_ids_.erase(id);
  changed_ids_.erase(id);
  removed_ids_.push_back(id);
}

void LandmarkLifeCycle::refreshActive(const CompressedEkf& filter) {
  for (const int slot : filter.activeLandmarks()) {
    RegisteredLandmark& landmark = registry_.bySlot(slot);
    registry_.move(landmark, filter.landmark(slot));
    if (landmark.diameter_state.exists()) {
      // Its Gaussian reaches below zero, the object does not.
      landmark.diameter_m = std::max(0.0, DiameterStates::mean(landmark.diameter_state, filter));
      landmark.diameter_variance = DiameterStates::variance(landmark.diameter_state, filter);
    }
    changed_ids_.insert(landmark.id);
  }
}

void LandmarkLifeCycle::refreshSettled(const CompressedEkf& filter) {
  for (RegisteredLandmark& landmark : registry_.slots()) {
    const int slot = landmark.slot;
    if (landmark.id < 0 || filter.isActive(slot)) continue;
    landmark.deviation_m = std::sqrt(filter.settledVariance(slot));
    const Vector2d position = filter.settledPosition(slot);
    if ((position - landmark.position).norm() > kNoticeableMove_m) {
      registry_.move(landmark, position);
    }
  }
  registry_.noteLargestDeviation();
}

void LandmarkLifeCycle::refreshNear(const Vector2d& centre, double radius_m,
                                    const CompressedEkf& filter) {
  for (const int slot : registry_.slotsNear(centre, radius_m)) {
    registry_.move(registry_.bySlot(slot), filter.landmark(slot));
  }
}

LandmarkLifeCycle::Changes LandmarkLifeCycle::takeChanges() {
  Changes changes;
  changes.changed_ids.assign(changed_ids_.begin(), changed_ids_.end());
  std::sort(changes.changed_ids.begin(), changes.changed_ids.end());
  changes.removed_ids = std::move(removed_ids_);
  std::sort(changes.removed_ids.begin(), changes.removed_ids.end());
  changes.merges.assign(merges_.begin() + static_cast<std::ptrdiff_t>(merges_taken_),
                        merges_.end());
  merges_taken_ = merges_.size();
  changed_ids_.clear();
  removed_ids_.clear();
  return changes;
}

void LandmarkLifeCycle::beginSession(double later_s) {
  tentative_.clear();
  searched_s_ = -std::numeric_limits<double>::infinity();
  if (later_s >= 0.0) return;
  for (RegisteredLandmark& landmark : registry_.slots()) {
    landmark.first_seen_s += later_s;
    landmark.last_seen_s += later_s;
  }
}

void LandmarkLifeCycle::clear() {
  for (const RegisteredLandmark& landmark : registry_.all()) removed_ids_.push_back(landmark.id);
  registry_.clear();
  tentative_.clear();
  diameters_.clear();
  lasting_errors_.clear();
  merges_.clear();
  merges_taken_ = 0;
  changed_ids_.clear();
  unconfirmed_ids_.clear();
  searched_s_ = -std::numeric_limits<double>::infinity();
  distinct_from_.clear();
  next_id_ = 0;
}

void LandmarkLifeCycle::goBackTo(const LandmarkLifeCycle& before) {
  std::vector<int> removed = std::move(removed_ids_);
  for (const RegisteredLandmark& landmark : registry_.slots()) {
    if (landmark.id >= 0) removed.push_back(landmark.id);
  }
  const std::size_t taken = merges_taken_;
  const std::unordered_set<int> pins = std::move(told_pins_);
  *this = before;
  const auto is_there = [this](int id) { return registry_.contains(id); };
  removed.erase(std::remove_if(removed.begin(), removed.end(), is_there), removed.end());
  removed_ids_ = std::move(removed);
  changed_ids_.clear();
  for (const RegisteredLandmark& landmark : registry_.slots()) {
    if (landmark.id >= 0) changed_ids_.insert(landmark.id);
  }
  merges_taken_ = std::min(taken, merges_.size());
  told_pins_ = pins;
  followMerges();
}

}  // namespace hymm::core
