#include "cekf/landmark_slam.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cekf/relative_covariance.h"
#include "common/cpu_timer.h"
#include "common/gaussian.h"

namespace hymm::core {
namespace {

// Beyond the reach of a sensor and of a large correction, a landmark's place may lag behind.
constexpr double kRefreshRadius_m = 100.0;

// Deviation of a slip beyond which a scan alone hardly tells where the vehicle went, among the many
// landmarks that it might see; constellations do.
constexpr double kFarthestSlip_m = 10.0;

// On variances: twice the deviations that the vehicle's configuration claims are worth a word.
constexpr double kNoisy = 4.0;

/// Whether at least half of the observations, and one, are of landmarks.
bool isExplained(const ScanAssociation& association) {
  return !association.measurements.empty() &&
         2 * association.measurements.size() >= association.slots.size();
}

double share(int part, int whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

}  // namespace

std::optional<ScanOutcome> LandmarkSlam::process(const SensorEvent& event) {
  if (const auto* input = std::get_if<MotionInput>(&event)) {
    const CpuTimer timer(cpu_times_.filter_s);
    takeMotion(*input);
    return std::nullopt;
  }
  if (const auto* fix = std::get_if<GpsFix>(&event)) {
    processGps(*fix);
    return std::nullopt;
  }
  const auto start = std::chrono::steady_clock::now();
  Sight sight = see(event);
  if (sight.set) goOnAfterLoad(sight.set->time_s);
  sight.mustBeNewTo(scan_clock_);
  refuseWithoutMotion(sight);
  if (!sight.set) return refuse(sight);
  const CpuTimer timer(cpu_times_.filter_s);
  return processSet(std::move(sight), start);
}

Sight LandmarkSlam::see(const SensorEvent& event) {
  return Sight::of(event, perception_, cpu_times_.perception_s);
}

ScanOutcome LandmarkSlam::refuse(const Sight& sight) {
  ++counts_.refused_scans;
  ScanOutcome outcome;
  outcome.reason = sight.problem;
  return outcome;
}

void LandmarkSlam::takeMotion(const MotionInput& input) {
  goOnAfterLoad(timeOf(input));
  beginWithMotion(timeOf(input));
  if (!estimate_.vehicle.takeInput(estimate_.filter, input)) ++counts_.refused_motion;
}

void LandmarkSlam::processGps(const GpsFix& fix) {
  if (!estimate_.gps) return;
  const CpuTimer timer(cpu_times_.filter_s);
  const bool usable = std::isfinite(fix.time_s) && fix.position.allFinite() &&
                      isCovariance(fix.covariance) && fix.antenna.allFinite();
  if (usable) goOnAfterLoad(fix.time_s);
  if (usable) estimate_.vehicle.moveTo(estimate_.filter, fix.time_s);
  const bool was_aligned = estimate_.gps->isAligned();
  std::optional<UpdateOutcome> update;
  if (usable) update = estimate_.gps->process(fix, estimate_.filter);
  if (update) {
    ++counts_.gps_used;
    if (update->largest_landmark_move_m > config_.large_correction_m) {
      life_cycle_.refreshActive(estimate_.filter);
      spreadCorrection();
    }
  } else if (!usable || was_aligned) {
    ++counts_.gps_rejected;
  }
}

ScanOutcome LandmarkSlam::processSet(Sight sight, Instant start) {
  ScanOutcome outcome;
  begin(sight);
  const ObservationSet& set = *sight.set;
  ScanAssociation association = associate(set);
  const bool updated = update(set, association, outcome);
  finish(std::move(sight), association, updated, start, outcome);
  return outcome;
}

ScanAssociation LandmarkSlam::associate(const ObservationSet& set) {
  const SensorPlacement sensor = sensorPlacement(set);
  LandmarkRegistry& registry = life_cycle_.registry();
  CompressedEkf& filter = estimate_.filter;
  if (place_finder_.isLost(set, registry, filter)) {
    if (auto found = associateAnywhere(set)) return std::move(*found);
    if (place_finder_.waits(set.time_s)) {
      ++counts_.scans_without_place;
      return ScanAssociator::associateNothing(set);
    }
  }
  ScanAssociation association = associator_.associate(set, sensor, registry, filter);
  if (isExplained(association) || !(config_.slip.probability > 0.0)) return association;
  const double times = config_.slip.factor * config_.slip.factor;
  const VehicleMatrix more = (times - 1.0) * estimate_.vehicle.motionNoise();
  if (more.topLeftCorner<2, 2>().trace() > kFarthestSlip_m * kFarthestSlip_m) return association;
  ScanAssociation slipped = associator_.associate(set, sensor, registry, filter, &more);
  const double gained = slipped.log_odds - association.log_odds;
  if (!isExplained(slipped) || gained < -std::log(config_.slip.probability)) return association;
  const VehicleMatrix still = VehicleMatrix::Identity(more.rows(), more.cols());
  filter.predict(filter.vehicle(), still, more);
  estimate_.vehicle.multiplyMotionNoise(times);
  ++counts_.slips;
  return slipped;
}

/// Puts the vehicle where all landmarks together say that it is, if they do.
std::optional<ScanAssociation> LandmarkSlam::associateAnywhere(const ObservationSet& set) {
  const auto place =
      place_finder_.find(set, sensorPlacement(set), life_cycle_.registry(), estimate_.filter);
  if (!place) return std::nullopt;
  placeVehicle(place->T_map_base, PlaceFinder::priorCovariance());
  estimate_.vehicle.beginMotionNoise();
  ++counts_.places_found;
  return associator_.associateAs(place->landmarks, set, sensorPlacement(set),
                                 life_cycle_.registry(), estimate_.filter);
}

void LandmarkSlam::begin(Sight& sight) {
  refuseUnusable(sight);
  const ObservationSet& set = *sight.set;
  scan_clock_.note(set.time_s, set.T_base_sensor);
  ++version_;
  life_cycle_.pin(pins_.at(set.time_s));
  estimate_.vehicle.moveTo(estimate_.filter, set.time_s);
  sight.undoSweep(estimate_.vehicle, estimate_.filter);
}

void LandmarkSlam::refuseUnusable(Sight& sight) {
  counts_.refused_observations += sight.dropUnusable();
}

SensorPlacement LandmarkSlam::sensorPlacement(const ObservationSet& set) const {
  return estimate_.vehicle.placement(set.T_base_sensor, estimate_.filter.vehicle());
}

/// False, and nothing is associated, if the update was refused.
bool LandmarkSlam::update(const ObservationSet& set, ScanAssociation& association,
                          ScanOutcome& outcome) {
  if (association.measurements.empty()) return true;
  life_cycle_.beginLastingErrors(sensorPlacement(set), association, estimate_.filter);
  const UpdateOutcome update = scan_update_.update(set, association, estimate_.vehicle,
                                                   life_cycle_.registry(), estimate_.filter);
  if (!std::isfinite(update.nis)) {
    association.slots.assign(association.slots.size(), ScanAssociation::kNone);
    return false;
  }
  const Eigen::VectorXd state = estimate_.filter.vehicle();
  estimate_.filter.setVehicleState(2, wrapAngle(state[2]));
  outcome.health.nis = update.nis;
  outcome.health.dof = 2 * static_cast<int>(association.measurements.size());
  outcome.largest_correction_m = update.largest_landmark_move_m;
  if (isExplained(association)) {
    place_finder_.tellExplained(set.time_s);
    estimate_.vehicle.learnMotionNoise(update);
    if (motionNoiseFactors().maxCoeff() >= kNoisy) ++counts_.noisy_scans;
    estimate_.vehicle.beginMotionNoise();
  }
  return true;
}

void LandmarkSlam::finish(Sight sight, const ScanAssociation& association, bool updated,
                          Instant start, ScanOutcome& outcome) {
  ObservationSet& set = *sight.set;
  outcome.accepted = true;
  const SensorPlacement sensor = sensorPlacement(set);
  if (use_ == MapUse::kExtend) {
    const bool shows_what_is_missed = updated && association.is_placed;
    extendMap(set, shows_what_is_missed ? sight.scan : nullptr, sensor, association, outcome);
  } else {
    const std::vector<int> none(association.slots.size(), ScanAssociation::kNone);
    countObservations(association, none, 0, outcome);
  }
  life_cycle_.forgetLastingErrors(sensorPlacement(set), estimate_.filter);
  if (outcome.largest_correction_m > config_.large_correction_m) spreadCorrection();
  const Eigen::Matrix3d relative = covarianceAmongSeen(association);
  keepActiveArea();

  ++counts_.scans;
  outcome.pose = pose();
  outcome.pose.time_s = set.time_s;
  outcome.pose.relative_covariance = relative;
  outcome.pose.sweep = std::move(sight.sweep);
  tellSensor(sensorPlacement(set), outcome.pose);
  describeHealth(set.time_s, start, outcome);
  outcome.observations = std::move(set);
}

/// What a set of observations does to the landmarks beside the update.
void LandmarkSlam::extendMap(const ObservationSet& set, const LaserScan* scan,
                             const SensorPlacement& sensor, const ScanAssociation& association,
                             ScanOutcome& outcome) {
  life_cycle_.confirm(set, association, estimate_.filter);
  const std::vector<int> created = life_cycle_.create(
      set, sensor, association, estimate_.vehicle.linearisedAt(), estimate_.filter);
  LandmarkLifeCycle::Missed missed;
  if (scan != nullptr) {
    missed = life_cycle_.miss(*scan, set, sensor, association, estimate_.filter);
    outcome.health.confirmed_missed = missed.confirmed;
    outcome.health.confirmed_expected = missed.confirmed + countConfirmed(association);
  }
  countObservations(association, created, missed.all, outcome);
  outcome.largest_correction_m =
      std::max({outcome.largest_correction_m, life_cycle_.merge(association, estimate_.filter),
                life_cycle_.closeLoop(set.time_s, estimate_.vehicle, estimate_.filter)});
  life_cycle_.refreshActive(estimate_.filter);
}

int LandmarkSlam::countConfirmed(const ScanAssociation& association) const {
  const LandmarkRegistry& registry = life_cycle_.registry();
  return static_cast<int>(
      std::count_if(association.slots.begin(), association.slots.end(), [&](int slot) {
        return slot != ScanAssociation::kNone && life_cycle_.isConfirmed(registry.bySlot(slot));
      }));
}

void LandmarkSlam::countObservations(const ScanAssociation& association,
                                     const std::vector<int>& created, int missed,
                                     ScanOutcome& outcome) {
  const auto n = static_cast<int>(association.slots.size());
  int associated = 0, unexplained = 0;
  for (std::size_t i = 0; i < association.slots.size(); ++i) {
    Association result;
    if (association.slots[i] != ScanAssociation::kNone) {
      result.landmark_id = life_cycle_.registry().bySlot(association.slots[i]).id;
      ++associated;
    } else if (created[i] != ScanAssociation::kNone) {
      result.landmark_id = life_cycle_.registry().bySlot(created[i]).id;
      ++unexplained;
    } else {
      const bool rejected = association.claimed[i] || association.ignored[i];
      result.landmark_id = rejected ? Association::kRejected : Association::kTentative;
      counts_.rejected += rejected ? 1U : 0U;
      ++unexplained;
    }
    outcome.associations.push_back(result);
  }
  counts_.bounded_associations += association.complete ? 0U : 1U;
  counts_.observations += association.slots.size();
  counts_.associated += static_cast<std::size_t>(associated);
  outcome.health.ambiguity = share(association.ambiguous, n);
  outcome.health.unexplained = share(unexplained, n);
  outcome.health.missed = share(missed, missed + associated);
}

/// Of the vehicle, while the landmarks of this scan are still active.
Eigen::Matrix3d LandmarkSlam::covarianceAmongSeen(const ScanAssociation& association) const {
  std::vector<int> seen;
  for (const int slot : association.slots) {
    const bool is_there = slot != ScanAssociation::kNone && estimate_.filter.isActive(slot);
    if (is_there) seen.push_back(slot);  // else it was merged into another, or dropped
  }
  return relativeCovariance(estimate_.filter, seen);
}

/// What a large correction has moved is looked for in its new place at once, and carried to all.
void LandmarkSlam::spreadCorrection() {
  ++counts_.map_corrections;
  life_cycle_.refreshNear(VehicleState::pose(estimate_.filter).position(), kRefreshRadius_m,
                          estimate_.filter);
  area_.demandUpdate();
}

/// Takes over what a global update that is done has made of the passive landmarks.
void LandmarkSlam::refreshIfSettled() {
  if (estimate_.filter.isGlobalUpdatePending()) return;
  if (estimate_.filter.globalUpdatesDone() == settled_updates_) return;
  settled_updates_ = estimate_.filter.globalUpdatesDone();
  life_cycle_.refreshSettled(estimate_.filter);
}

void LandmarkSlam::keepActiveArea() {
  const double worker_s = estimate_.filter.workerCpu_s();
  if (area_.follow(VehicleState::pose(estimate_.filter).position())) {
    const bool drops = use_ == MapUse::kExtend;
    if (drops) life_cycle_.dropUnconfirmed(lastScan_s(), estimate_.filter);
  }
  refreshIfSettled();
  area_.updateIfDue(estimate_.filter);
  refreshIfSettled();
  inline_worker_s_ += estimate_.filter.workerCpu_s() - worker_s;
}

// --- For the way back ------------------------------------------------------------------------

void LandmarkSlam::holdGlobalUpdates(bool hold) {
  holds_global_updates_ = hold;
  estimate_.filter.holdGlobalUpdates(hold);
  if (!hold) estimate_.filter.releaseGlobalUpdate();
}

LocalStateRing::Memory LandmarkSlam::remembered() const {
  return std::make_shared<const FilterMemory>(
      FilterMemory{scan_clock_, estimate_.vehicle, estimate_.filter.localState(), estimate_.gps,
                   life_cycle_, scan_update_, place_finder_, area_, settled_updates_});
}

void LandmarkSlam::recall(const FilterMemory& memory) {
  estimate_.filter.goBackTo(memory.filter);
  estimate_.vehicle = memory.vehicle;
  estimate_.gps = memory.gps;
  scan_update_ = memory.scan_update;
  place_finder_ = memory.place_finder;
  area_ = memory.area;
  settled_updates_ = memory.settled_updates;
  scan_clock_ = memory.scan_clock;
}

}  // namespace hymm::core
