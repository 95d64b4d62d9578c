/// When two landmarks are one object, and how they become one.
#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/LU>

#include "cekf/landmark_life_cycle.h"
#include "cekf/loop_bend.h"
#include "cekf/relinearisation.h"
#include "cekf/vehicle_state.h"

namespace hymm::core {

using Eigen::Matrix2d;
using Eigen::Vector2d;

namespace {

// Noise of the pseudo-observation "these two are one object".
constexpr double kFusionVariance = 1e-4;

// Between two searches for duplicates: what they find changes with the landmarks that come into
// view.
constexpr double kSearchPeriod_s = 1.0;

}  // namespace

double LandmarkLifeCycle::merge(const ScanAssociation& association, CompressedEkf& filter) {
  if (config_.merge_distance_m <= 0.0) return 0.0;
  for (const int slot : association.slots) {
    if (slot == ScanAssociation::kNone) continue;
    const RegisteredLandmark& landmark = registry_.bySlot(slot);
    for (const int other_slot : registry_.slotsNear(landmark.position, config_.merge_distance_m)) {
      if (other_slot == slot) continue;
      const RegisteredLandmark& other = registry_.bySlot(other_slot);
      if (!areOneObject(landmark, other, filter)) continue;
      // The older one stays: others may already refer to it.
      const bool is_older = landmark.id < other.id;
      // One a scan is plenty, and references are void now.
      const DuplicateLandmarks pair{is_older ? slot : other_slot, is_older ? other_slot : slot};
      relineariseAtOnePlace(pair, filter);
      return fuse({pair}, filter);
    }
  }
  return 0.0;
}

/// Which turn of the map would tear them apart: none, once their covariances belong to one place.
void LandmarkLifeCycle::relineariseAtOnePlace(const DuplicateLandmarks& pair,
                                              CompressedEkf& filter) {
  const auto fused =
      at_first_estimates_ ? filter.statesAfter(samePlaces({pair}, filter)) : std::nullopt;
  if (!fused) return;
  const Vector2d place = filter.landmarkAmong(*fused, pair.kept);
  relinearise(registry_.bySlot(pair.kept), place, filter);
  relinearise(registry_.bySlot(pair.gone), place, filter);
}

bool LandmarkLifeCycle::areOneObject(const RegisteredLandmark& a, const RegisteredLandmark& b,
                                     CompressedEkf& filter) const {
  if (areDistinct(a.id, b.id)) return false;
  if (a.identity >= 0 || b.identity >= 0) return false;
  if (!mayBeOneKind(a.type, b.type)) return false;
  filter.activate(a.slot);
  filter.activate(b.slot);
  const Vector2d difference = filter.landmark(a.slot) - filter.landmark(b.slot);
  const Matrix2d cross = filter.covariance(a.slot, b.slot);
  const Matrix2d covariance = filter.covariance(a.slot, a.slot) +
                              filter.covariance(b.slot, b.slot) - cross - cross.transpose() +
                              kFusionVariance * Matrix2d::Identity();
  return difference.dot(covariance.inverse() * difference) <= merge_gate_;
}

bool LandmarkLifeCycle::areDistinct(int id_a, int id_b) const {
  const auto distinct = distinct_from_.find(id_a);
  return distinct != distinct_from_.end() && distinct->second.count(id_b) > 0;
}

double LandmarkLifeCycle::closeLoop(double time_s, VehicleState& vehicle, CompressedEkf& filter) {
  if (time_s - searched_s_ < kSearchPeriod_s) return 0.0;
  searched_s_ = time_s;
  const auto are_distinct = [this](int a, int b) {
    return areDistinct(registry_.bySlot(a).id, registry_.bySlot(b).id);
  };
  const DuplicatesFound found = duplicate_search_.find(
      time_s, VehicleState::pose(filter).position(), are_distinct, registry_, filter);
  if (found.pairs.empty()) return 0.0;
  if (found.slip) addSlip(found, filter);
  const auto same_places = [&] { return samePlaces(found.pairs, filter); };
  bendMap(same_places, large_correction_m_, vehicle, registry_, filter);
  return fuse(found.pairs, filter);
}

/// The vehicle slipped after it had lost sight of the older landmarks. What has come into the map
/// since lies with the vehicle, as far as it is active.
void LandmarkLifeCycle::addSlip(const DuplicatesFound& found, CompressedEkf& filter) {
  double since_s = -std::numeric_limits<double>::infinity();
  std::set<int> with_vehicle;
  for (const DuplicateLandmarks& pair : found.pairs) {
    since_s = std::max(since_s, registry_.bySlot(pair.kept).last_seen_s);
    with_vehicle.insert(pair.gone);
  }
  for (const int slot : filter.activeLandmarks()) {
    if (registry_.bySlot(slot).first_seen_s > since_s) with_vehicle.insert(slot);
  }
  filter.addRigidNoise({with_vehicle.begin(), with_vehicle.end()}, *found.slip);
  ++counts_.slips;
}

std::vector<SparseMeasurement> LandmarkLifeCycle::samePlaces(
    const std::vector<DuplicateLandmarks>& duplicates, const CompressedEkf& filter) {
  std::vector<SparseMeasurement> same_places;
  for (const DuplicateLandmarks& pair : duplicates) {
    SparseMeasurement same_place;
    same_place.innovation = filter.landmark(pair.gone) - filter.landmark(pair.kept);
    same_place.H_vehicle.resize(2, 0);
    same_place.landmarks[0] = pair.kept;
    same_place.landmarks[1] = pair.gone;
    same_place.H_landmarks[0] = Matrix2d::Identity();
    same_place.H_landmarks[1] = -Matrix2d::Identity();
    same_place.noise = kFusionVariance * Matrix2d::Identity();
    same_places.push_back(same_place);
  }
  return same_places;
}

double LandmarkLifeCycle::fuse(const std::vector<DuplicateLandmarks>& duplicates,
                               CompressedEkf& filter) {
  const UpdateOutcome outcome = filter.update(samePlaces(duplicates, filter));
  if (!std::isfinite(outcome.nis)) return 0.0;
  for (const DuplicateLandmarks& pair : duplicates) {
    const RegisteredLandmark gone = registry_.bySlot(pair.gone);
    takeOver(gone, registry_.bySlot(pair.kept));
    drop(gone.id, filter);
    merges_.push_back({gone.id, registry_.bySlot(pair.kept).id});
    ++counts_.merged;
  }
  followMerges();
  return outcome.largest_landmark_move_m;
}

void LandmarkLifeCycle::takeOver(const RegisteredLandmark& gone, RegisteredLandmark& kept) {
  kept.observations += gone.observations;
  kept.farthest_seen_m = std::max(kept.farthest_seen_m, gone.farthest_seen_m);
  kept.last_seen_s = std::max(kept.last_seen_s, gone.last_seen_s);
  kept.existence_log_odds = std::max(kept.existence_log_odds, gone.existence_log_odds);
  if (isConfirmed(kept)) unconfirmed_ids_.erase(kept.id);
  for (const int other : std::set<int>(distinct_from_[gone.id])) {
    if (other == kept.id) continue;
    distinct_from_[kept.id].insert(other);
    distinct_from_[other].insert(kept.id);
  }
}

}  // namespace hymm::core
