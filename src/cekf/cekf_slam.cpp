#include "cekf/cekf_slam.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <limits>
#include <utility>

#include "cekf/active_area.h"
#include "cekf/compressed_ekf.h"
#include "cekf/gps_datum.h"
#include "cekf/landmark_life_cycle.h"
#include "cekf/landmark_pins.h"
#include "cekf/landmark_requests.h"
#include "cekf/local_state_ring.h"
#include "cekf/map_snapshot.h"
#include "cekf/path_closing.h"
#include "cekf/relative_covariance.h"
#include "cekf/scan_associator.h"
#include "cekf/scan_update.h"
#include "cekf/vehicle_state.h"
#include "common/cpu_timer.h"
#include "common/gaussian.h"
#include "common/state_archive.h"
#include "perception/perception.h"
#include "perception/scan_check.h"

namespace hymm::core {
namespace {

bool isUsable(const Observation& observation) {
  return std::isfinite(observation.range_m) && observation.range_m > 0.0 &&
         std::isfinite(observation.bearing_rad) && isCovariance(observation.covariance);
}

// Beyond the reach of a sensor and of a large correction, a landmark's place may lag behind.
constexpr double kRefreshRadius_m = 100.0;

// Of a vehicle that was carried: far beyond what particles that have converged leave open, and what
// a scan's way is.
constexpr double kElsewhereDeviation_m = 5.0;
constexpr double kElsewhereDeviation_rad = 0.3;

/// Any diameter that a trunk may have is as likely as any other.
DiameterPrior diameterPrior(const TrunkConfig& trunks) {
  return {0.5 * (trunks.min_diameter_m + trunks.max_diameter_m),
          (trunks.max_diameter_m - trunks.min_diameter_m) / std::sqrt(12.0)};
}

// Stamps that have gone through a message or a file may differ by rounding.
constexpr double kSameStamp_s = 1e-4;

double share(int part, int whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

}  // namespace

class CekfSlam::Impl {
 public:
  Impl(const CekfSlamConfig& config, const VehicleConfig& vehicle, GlobalUpdates global_updates)
      : config_(config),
        vehicle_config_(vehicle),
        global_updates_(global_updates),
        perception_(config.perception),
        associator_(config.association, config.update.atFirstEstimates()
                                            ? std::optional(config.update.relinearise_m)
                                            : std::nullopt),
        scan_update_(config.update.atFirstEstimates()
                         ? ScanUpdate(config.update.max_iterations, config.large_correction_m)
                         : ScanUpdate(config.update.max_iterations)),
        life_cycle_(config.landmarks, config.association, diameterPrior(config.perception.trunks),
                    config.update.atFirstEstimates()),
        pins_(config.landmarks.pin_delay_s),
        area_(config.active_area),
        path_closing_(config.resumption, config.update.atFirstEstimates()),
        estimate_(newEstimate()) {}

  std::optional<ScanOutcome> process(const SensorEvent& event) {
    ring_.add(event);
    return apply(event);
  }

  void takeMotion(const MotionInput& input) {
    goOnAfterLoad(timeOf(input));
    const CpuTimer timer(cpu_times_.filter_s);
    if (waiting_) {
      if (!waiting_->vehicle.takeInput(waiting_->filter, input)) ++counts_.refused_motion;
      return;
    }
    if (!estimate_.vehicle.takeInput(estimate_.filter, input)) ++counts_.refused_motion;
  }

  ScanOutcome processScan(const ScanEvent& event) {
    const auto start = std::chrono::steady_clock::now();
    if (const auto problem = scanProblem(event.scan)) return refuse(*problem);
    goOnAfterLoad(event.scan.time_s);
    if (event.scan.time_s <= newestScan_s())
      return refuse("the scan is not later than the last one");
    ObservationSet set;
    set.time_s = event.scan.time_s;
    set.T_base_sensor = event.T_base_laser;
    {
      const CpuTimer timer(cpu_times_.perception_s);
      set.observations = perception_.detect(event.scan);
    }
    return processSet(std::move(set), &event.scan, start);
  }

  ScanOutcome processObservations(const ObservationSet& set) {
    const auto start = std::chrono::steady_clock::now();
    if (!std::isfinite(set.time_s)) return refuse("the observations' time is not finite");
    goOnAfterLoad(set.time_s);
    if (set.time_s <= newestScan_s()) {
      return refuse("the observations are not later than the last ones");
    }
    return processSet(set, nullptr, start);
  }

  void processGps(const GpsFix& fix) {
    if (!estimate_.gps || waiting_) return;
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

  void reset() {
    waiting_.reset();
    ring_.clear();
    estimate_.filter.finishGlobalUpdate();
    ++counts_.resets;
    ++version_;
    life_cycle_.clear();
    pins_.clear();
    area_.reset();
    past_gaps_ += estimate_.vehicle.gaps();
    past_worker_s_ += estimate_.filter.workerCpu_s();
    estimate_ = newEstimate();
    settled_updates_ = 0;
    last_scan_s_ = -std::numeric_limits<double>::infinity();
    use_ = MapUse::kExtend;
    is_just_loaded_ = false;
  }

  std::string saveState() {
    StateWriter archive;
    archive(std::string(kStateKind), kStateVersion);
    estimate_.vehicle.save(archive);
    archive(estimate_.gps.has_value());
    estimate_.filter.save(archive);
    describeState(archive);
    return archive.takeBytes();
  }

  void checkState(std::string_view bytes, const std::string& name) const {
    Impl trial(config_, vehicle_config_, GlobalUpdates::kInline);
    trial.restoreState(bytes, name);
  }

  void loadState(std::string_view bytes, const std::string& name, MapUse use) {
    checkState(bytes, name);
    const std::uint64_t version = version_;
    reset();
    restoreState(bytes, name);
    if (version > 0) version_ = std::max(version_, version + 1);
    told_version_ = version_;
    use_ = use;
    is_just_loaded_ = true;
    estimate_.filter.fixLandmarks(use == MapUse::kLocalise);
  }

  void placeVehicle(const Pose2& T_map_base, const Eigen::Matrix3d& covariance) {
    const Eigen::MatrixXd independent = Eigen::MatrixXd::Zero(3, estimate_.vehicle.size());
    estimate_.filter.initialiseVehicleStates(0, T_map_base.vector(), independent, covariance);
    estimate_.vehicle.linearisePositionAt(T_map_base.position());
    ++version_;
  }

  PoseEstimate pose() const {
    const VehicleState& vehicle = waiting_ ? waiting_->vehicle : estimate_.vehicle;
    const CompressedEkf& filter = waiting_ ? waiting_->filter : estimate_.filter;
    PoseEstimate pose;
    pose.time_s = vehicle.time_s();
    pose.T_map_base = VehicleState::pose(filter);
    pose.covariance = filter.vehicleCovariance().topLeftCorner<3, 3>();
    pose.relative_covariance = pose.covariance;  // what is common to all is not told apart
    pose.map_version = version_;
    return pose;
  }

  Calibration calibration() const {
    return estimate_.vehicle.calibration(estimate_.filter.vehicle());
  }
  Eigen::Matrix3d calibrationCovariance() const {
    return estimate_.vehicle.calibrationCovariance(estimate_.filter.vehicleCovariance());
  }

  LaserCalibration laserCalibration() const {
    return estimate_.vehicle.laserCalibration(estimate_.filter);
  }

  std::uint64_t version() const { return version_; }
  std::size_t landmarkCount() const { return life_cycle_.registry().size(); }

  void requestMap(double block_range_m, std::function<void(LandmarkMap)> take) {
    LandmarkMap header;
    header.version = version_;
    header.time_s = estimate_.vehicle.time_s();
    header.merges = life_cycle_.merges();
    core::requestMap(life_cycle_.registry(), std::move(header), block_range_m, estimate_.filter,
                     std::move(take));
  }

  LandmarkMap landmarkMap(double block_range_m) {
    // Held by the job alone: should that fail, get() throws.
    auto promise = std::make_shared<std::promise<LandmarkMap>>();
    std::future<LandmarkMap> map = promise->get_future();
    requestMap(block_range_m, [promise = std::move(promise)](LandmarkMap made) {
      promise->set_value(std::move(made));
    });
    return map.get();
  }

  bool hasLandmark(int id) const { return life_cycle_.registry().contains(id); }

  bool requestJointLandmarks(const std::vector<int>& ids,
                             std::function<void(JointLandmarks)> take) {
    JointLandmarks header;
    header.version = version_;
    header.time_s = estimate_.vehicle.time_s();
    header.ids = ids;
    return core::requestJointLandmarks(life_cycle_.registry(), std::move(header), estimate_.filter,
                                       std::move(take));
  }

  bool requestVehicleAmongLandmarks(const std::vector<int>& ids,
                                    std::function<void(VehicleAmongLandmarks)> take) {
    VehicleAmongLandmarks header;
    header.vehicle = {VehicleState::pose(estimate_.filter),
                      estimate_.filter.vehicleCovariance().topLeftCorner<3, 3>()};
    header.landmarks.version = version_;
    header.landmarks.time_s = estimate_.vehicle.time_s();
    header.landmarks.ids = ids;
    return core::requestVehicleAmongLandmarks(life_cycle_.registry(), std::move(header),
                                              estimate_.filter, std::move(take));
  }

  LandmarkUpdate takeUpdate() {
    LandmarkLifeCycle::Changes changes = life_cycle_.takeChanges();
    LandmarkUpdate update;
    update.since_version = std::exchange(told_version_, version_);
    update.version = version_;
    for (const int id : changes.changed_ids) {
      update.changed.push_back(estimateOf(life_cycle_.registry().byId(id), estimate_.filter));
    }
    update.removed_ids = std::move(changes.removed_ids);
    update.merges = std::move(changes.merges);
    return update;
  }

  void pinLandmarks(double time_s, const std::vector<int>& ids) { pins_.tell(time_s, ids); }

  void keepLocalStates(int scans) {
    if (waiting_) return;
    ring_.setScans(scans);
    estimate_.filter.holdGlobalUpdates(ring_.isKept());
    if (!ring_.isKept()) estimate_.filter.releaseGlobalUpdate();
  }

  std::optional<LocalStateSpan> localStates() const { return ring_.span(); }

  bool suspend(double time_T0_s) {
    const auto way = findWay(time_T0_s);
    if (!way) return false;
    const CpuTimer timer(cpu_times_.filter_s);
    goAlong(*way);
    ++version_;
    ring_.goBackTo(*way, remembered());
    waiting_.emplace(
        Waiting{estimate_.vehicle,
                CompressedEkf(estimate_.filter.vehicle(), estimate_.filter.vehicleCovariance()),
                last_scan_s_});
    replay(way->since);
    return true;
  }

  bool isSuspended() const { return waiting_.has_value(); }

  Resumption resume(double time_T0_s, const std::vector<PlaceAtScan>& path, bool elsewhere) {
    const std::string problem = pathProblem(time_T0_s, path);
    if (!problem.empty()) return refuse(Resumption::Refusal::kUnusablePath, problem);
    return goBackAndOn(time_T0_s, [&](const LocalStateRing::Events& events) {
      if (elsewhere) beginElsewhere(path.front().T_map_base);
      return replayAlong(path, events);
    });
  }

  Resumption resumeWithoutClosing(double time_T0_s) {
    return goBackAndOn(time_T0_s, [&](const LocalStateRing::Events& events) {
      Resumption result;
      for (const auto& event : events) moveAlong(*event, result);
      result.reason = "On by dead reckoning from " + std::to_string(time_T0_s) + " s over " +
                      std::to_string(result.scans) + " scans; no loop was closed.";
      return result;
    });
  }

  bool isGlobalUpdatePending() { return estimate_.filter.isGlobalUpdatePending(); }

  Counts counts() const {
    Counts counts = counts_;
    counts.motion_gaps = past_gaps_ + estimate_.vehicle.gaps();
    counts.landmarks_created = life_cycle_.counts().created;
    counts.landmarks_dropped = life_cycle_.counts().dropped;
    counts.landmarks_merged = life_cycle_.counts().merged;
    counts.iterated_updates = scan_update_.iterated();
    counts.area_switches = area_.counts().switches;
    counts.global_updates = area_.counts().global_updates;
    counts.deferred_global_updates = area_.counts().deferred;
    counts.global_update_waits = area_.counts().waits;
    return counts;
  }

  CpuTimes cpuTimes() const {
    CpuTimes times = cpu_times_;
    times.worker_s = past_worker_s_ + estimate_.filter.workerCpu_s();
    // What an inline worker does after the last scan is not in the filter's time.
    if (global_updates_ == GlobalUpdates::kInline) times.filter_s -= inline_worker_s_;
    return times;
  }

 private:
  static constexpr const char* kStateKind = "hymm landmarks";
  static constexpr std::uint32_t kStateVersion = 1;

  /// What begins anew with each recording.
  struct Estimate {
    VehicleState vehicle;
    CompressedEkf filter;
    std::optional<GpsDatum> gps;
  };

  Estimate newEstimate() const {
    VehicleState vehicle(vehicle_config_, config_.motion_input == "odom", config_.gps.enabled,
                         config_.update.atFirstEstimates());
    CompressedEkf filter(vehicle.initialState(), vehicle.initialCovariance(), global_updates_);
    Estimate estimate{vehicle, std::move(filter), std::nullopt};
    if (config_.gps.enabled) estimate.gps.emplace(config_.gps, vehicle.gpsDatumIndex());
    estimate.filter.holdGlobalUpdates(ring_.isKept());
    return estimate;
  }

  /// The vehicle alone, while the filter waits at an earlier scan.
  struct Waiting {
    VehicleState vehicle;
    CompressedEkf filter;
    double last_scan_s;
  };

  std::optional<ScanOutcome> apply(const SensorEvent& event) {
    struct Visitor {
      Impl& impl;
      std::optional<ScanOutcome> operator()(const MotionInput& input) const {
        impl.takeMotion(input);
        return std::nullopt;
      }
      std::optional<ScanOutcome> operator()(const ScanEvent& scan) const {
        return impl.processScan(scan);
      }
      std::optional<ScanOutcome> operator()(const ObservationSet& set) const {
        return impl.processObservations(set);
      }
      std::optional<ScanOutcome> operator()(const GpsFix& fix) const {
        impl.processGps(fix);
        return std::nullopt;
      }
      std::optional<ScanOutcome> operator()(const ClockReset&) const {
        impl.reset();
        return std::nullopt;
      }
    };
    return std::visit(Visitor{*this}, event);
  }

  double newestScan_s() const { return waiting_ ? waiting_->last_scan_s : last_scan_s_; }

  template <class Archive>
  void describeState(Archive& archive) {
    archive(version_, last_scan_s_, settled_updates_, life_cycle_, pins_, area_);
    if (estimate_.gps) archive(*estimate_.gps);
  }

  /// Into an engine that has just begun, or was reset.
  void restoreState(std::string_view bytes, const std::string& name) {
    StateReader archive(bytes, name);
    archive.require(archive.read<std::string>() == kStateKind, "it holds no landmarks");
    archive.requireSame(archive.read<std::uint32_t>() == kStateVersion,
                        "it is of another version of hymm; load it with that.");
    estimate_.vehicle.restore(archive);
    archive.require(archive.read<bool>() == estimate_.gps.has_value(),
                    "its GPS states are missing");
    estimate_.filter.restore(archive);
    describeState(archive);
    archive.requireEnd();
    for (const RegisteredLandmark& landmark : life_cycle_.registry().slots()) {
      const DiameterState& diameter = landmark.diameter_state;
      const bool is_there = landmark.id < 0 || (estimate_.filter.holds(landmark.slot) &&
                                                (!diameter.exists() || isThere(diameter)));
      archive.require(is_there, "a landmark has no estimate");
    }
  }

  bool isThere(const DiameterState& diameter) const {
    return estimate_.filter.holds(diameter.slot) && (diameter.half == 0 || diameter.half == 1);
  }

  /// The first event after a map was loaded: if it does not follow at once what the map saw last,
  /// the clock begins anew, and what was seen earlier was seen before that.
  void goOnAfterLoad(double time_s) {
    if (!is_just_loaded_) return;
    is_just_loaded_ = false;
    const double saved_s = estimate_.vehicle.time_s();
    if (time_s >= saved_s && time_s <= saved_s + estimate_.vehicle.holdLimit_s()) return;
    estimate_.vehicle.restartClock();
    last_scan_s_ = -std::numeric_limits<double>::infinity();
    life_cycle_.beginSession(std::isfinite(saved_s) ? time_s - saved_s : 0.0);
    pins_.beginSession();
  }

  ScanOutcome refuse(const std::string& reason) {
    ++counts_.refused_scans;
    ScanOutcome outcome;
    outcome.reason = reason;
    return outcome;
  }

  ScanOutcome processSet(ObservationSet set, const LaserScan* scan,
                         std::chrono::steady_clock::time_point start) {
    const CpuTimer timer(cpu_times_.filter_s);
    if (waiting_) return wait(std::move(set), start);
    ScanOutcome outcome;
    begin(set);
    ScanAssociation association =
        associator_.associate(set, sensorPlacement(set), life_cycle_.registry(), estimate_.filter);
    const bool updated = update(set, association, outcome);
    finish(std::move(set), scan, association, updated, start, outcome);
    return outcome;
  }

  /// Takes the vehicle to where it should be at the time of the set.
  void begin(ObservationSet& set) {
    refuseUnusable(set);
    last_scan_s_ = set.time_s;
    ++version_;
    life_cycle_.pin(pins_.at(set.time_s));
    if (!estimate_.vehicle.hasInput()) ++counts_.scans_without_motion;
    estimate_.vehicle.moveTo(estimate_.filter, set.time_s);
  }

  /// What follows from a set once the filter has learnt from it.
  void finish(ObservationSet set, const LaserScan* scan, const ScanAssociation& association,
              bool updated, std::chrono::steady_clock::time_point start, ScanOutcome& outcome) {
    outcome.accepted = true;
    const SensorPlacement sensor = sensorPlacement(set);
    if (use_ == MapUse::kExtend) {
      extendMap(set, updated ? scan : nullptr, sensor, association, outcome);
    } else {
      const std::vector<int> none(association.slots.size(), ScanAssociation::kNone);
      countObservations(association, none, 0, outcome);
    }
    if (outcome.largest_correction_m > config_.large_correction_m) spreadCorrection();
    const Eigen::Matrix3d relative = covarianceAmongSeen(association);
    keepActiveArea();

    ++counts_.scans;
    outcome.pose = pose();
    outcome.pose.time_s = set.time_s;
    outcome.pose.relative_covariance = relative;
    const SensorPlacement placement = sensorPlacement(set);
    outcome.pose.T_base_sensor = placement.T_base_sensor;
    outcome.pose.range_offset_m = placement.range_offset_m;
    describeHealth(set.time_s, start, outcome);
    outcome.observations = std::move(set);
    keepLocalState();
  }

  /// A scan while the filter waits: the vehicle goes on by its motion.
  ScanOutcome wait(ObservationSet set, std::chrono::steady_clock::time_point start) {
    ScanOutcome outcome;
    outcome.accepted = outcome.suspended = true;
    refuseUnusable(set);
    waiting_->last_scan_s = set.time_s;
    waiting_->vehicle.moveTo(waiting_->filter, set.time_s);
    if (!replaying_) {
      counts_.forgotten_states += ring_.dropScansBefore(set.time_s - kLongestSuspension_s);
    }
    ++counts_.scans;
    counts_.observations += set.observations.size();
    outcome.associations.resize(set.observations.size());
    outcome.pose = pose();
    const SensorPlacement sensor =
        waiting_->vehicle.placement(set.T_base_sensor, waiting_->filter.vehicle());
    outcome.pose.T_base_sensor = sensor.T_base_sensor;
    outcome.pose.range_offset_m = sensor.range_offset_m;
    describeHealth(set.time_s, start, outcome);
    outcome.observations = std::move(set);
    return outcome;
  }

  // --- The way back --------------------------------------------------------------------------

  LocalStateRing::Memory remembered() const {
    return std::make_shared<const FilterMemory>(
        FilterMemory{last_scan_s_, estimate_.vehicle, estimate_.filter.localState(), estimate_.gps,
                     life_cycle_, scan_update_, area_, settled_updates_});
  }

  /// All but the landmarks' register.
  void recall(const FilterMemory& memory) {
    estimate_.filter.goBackTo(memory.filter);
    estimate_.vehicle = memory.vehicle;
    estimate_.gps = memory.gps;
    scan_update_ = memory.scan_update;
    area_ = memory.area;
    settled_updates_ = memory.settled_updates;
    last_scan_s_ = memory.last_scan_s;
  }

  /// After a scan: what can be gone back to, and what need not be held back any more.
  void keepLocalState() {
    if (!ring_.isKept() || replaying_) return;
    CompressedEkf& filter = estimate_.filter;
    counts_.forgotten_states += ring_.giveUp(
        [&filter](const FilterMemory& memory) { return filter.canGoBackTo(memory.filter); });
    if (ring_.noteScan(last_scan_s_)) ring_.remember(remembered());
    if (filter.isGlobalUpdateHeldSince(ring_.oldest()->filter)) filter.releaseGlobalUpdate();
  }

  std::optional<LocalStateRing::Way> findWay(double time_s) const {
    auto way = ring_.findWay(time_s);
    const bool is_open = way && estimate_.filter.canGoBackTo(way->memory->filter);
    return is_open ? std::move(way) : std::nullopt;
  }

  /// Goes back to a memory, and from there to a scan: the same way, to the bit.
  void goAlong(const LocalStateRing::Way& way) {
    const int next_id = life_cycle_.nextId();
    waiting_.reset();
    recall(*way.memory);
    life_cycle_.goBackTo(way.memory->life_cycle);
    replay(way.to_scan);
    life_cycle_.skipIds(next_id);  // those that were given out since mean other landmarks
  }

  /// Each event counts once, when it comes.
  void replay(const LocalStateRing::Events& events) {
    const Counts counts = counts_;
    const bool was_replaying = std::exchange(replaying_, true);
    for (const auto& event : events) apply(*event);
    replaying_ = was_replaying;
    counts_ = counts;
  }

  /// Goes back to the scan at T0 and on from there by `go`. If that refuses, nothing has happened.
  template <typename Go>
  Resumption goBackAndOn(double time_T0_s, Go go) {
    const auto way = findWay(time_T0_s);
    if (!way) return refuse(Resumption::Refusal::kNotKept, notKept(time_T0_s));
    const CpuTimer timer(cpu_times_.filter_s);
    const LocalStateRing::Memory now = remembered();
    const std::uint64_t version = version_;
    const Counts counts = counts_;
    std::optional<Waiting> waiting = std::move(waiting_);
    goAlong(*way);
    replaying_ = true;
    Resumption result = go(way->since);
    replaying_ = false;
    counts_ = counts;
    if (!result.accepted()) {
      recall(*now);
      life_cycle_ = now->life_cycle;
      version_ = version;
      waiting_ = std::move(waiting);
      return refuse(result.refusal, result.reason);
    }
    ++counts_.resumed;
    ++version_;
    ring_.clear();
    if (ring_.isKept()) ring_.remember(remembered());
    return result;
  }

  Resumption refuse(Resumption::Refusal refusal, const std::string& reason) {
    ++counts_.refused_resumptions;
    Resumption result;
    result.refusal = refusal;
    result.reason = reason;
    return result;
  }

  std::string notKept(double time_T0_s) const {
    const auto span = ring_.span();
    const std::string asked = "There is no way back to a scan at " + std::to_string(time_T0_s);
    if (!span) return asked + " s: no local states are kept.";
    return asked + " s: those from " + std::to_string(span->oldest_s) + " to " +
           std::to_string(span->newest_s) + " s are kept.";
  }

  static std::string pathProblem(double time_T0_s, const std::vector<PlaceAtScan>& path) {
    if (path.empty()) return "The path has no pose.";
    double last_s = time_T0_s;
    for (const PlaceAtScan& place : path) {
      if (!std::isfinite(place.time_s) || !place.T_map_base.vector().allFinite()) {
        return "A pose of the path is not finite.";
      }
      if (place.time_s <= last_s) {
        return "The path has to begin after the scan that it leads back to, and go on in the order "
               "of time.";
      }
      last_s = place.time_s;
    }
    return {};
  }

  /// The set of a scan or observation event that can still be processed.
  std::optional<ObservationSet> usableSet(const SensorEvent& event) const {
    std::optional<ObservationSet> set;
    if (const auto* observations = std::get_if<ObservationSet>(&event)) set = *observations;
    if (const auto* scan = std::get_if<ScanEvent>(&event)) {
      if (scanProblem(scan->scan)) return std::nullopt;
      set = ObservationSet{};
      set->time_s = scan->scan.time_s;
      set->T_base_sensor = scan->T_base_laser;
      set->observations = perception_.detect(scan->scan);
    }
    if (set && !(set->time_s > last_scan_s_)) return std::nullopt;
    return set;
  }

  /// Gives up what the filter holds of the pose: as a motion that has forgotten where it came from.
  void beginElsewhere(const Pose2& T_map_base) {
    Eigen::VectorXd vehicle = estimate_.filter.vehicle();
    vehicle.head<3>() = T_map_base.vector();
    Eigen::MatrixXd J = Eigen::MatrixXd::Identity(vehicle.size(), vehicle.size());
    Eigen::MatrixXd Q = Eigen::MatrixXd::Zero(vehicle.size(), vehicle.size());
    J.topLeftCorner<3, 3>().setZero();
    Q.diagonal().head<3>() << kElsewhereDeviation_m * kElsewhereDeviation_m,
        kElsewhereDeviation_m * kElsewhereDeviation_m,
        kElsewhereDeviation_rad * kElsewhereDeviation_rad;
    estimate_.filter.predict(vehicle, J, Q);
    estimate_.vehicle.linearisePositionAt(T_map_base.position());
  }

  /// An event that moves the vehicle only.
  void moveAlong(const SensorEvent& event, Resumption& result) {
    if (const auto* input = std::get_if<MotionInput>(&event)) takeMotion(*input);
    std::optional<ObservationSet> set = usableSet(event);
    if (!set) return;
    begin(*set);
    ++result.scans;
  }

  /// Closes the loop at the first scan that lets it, and processes as ever what follows.
  Resumption replayAlong(const std::vector<PlaceAtScan>& path,
                         const LocalStateRing::Events& events) {
    Resumption result;
    result.refusal = Resumption::Refusal::kNothingPlain;
    result.reason = "No scan of the path shows " + std::to_string(config_.resumption.least_pairs) +
                    " landmarks beyond doubt; nothing was closed.";
    auto place = path.begin();
    for (const auto& kept : events) {
      const SensorEvent& event = *kept;
      if (result.accepted()) {
        if (apply(event)) ++result.scans;
        continue;
      }
      const double time_s = timeOf(event);
      while (place != path.end() && place->time_s < time_s - kSameStamp_s) ++place;
      const bool on_path = place != path.end() && place->time_s <= time_s + kSameStamp_s;
      if (!on_path || !usableSet(event)) {
        moveAlong(event, result);
        continue;
      }
      closeAt(place->T_map_base, event, result);
      if (result.refusal == Resumption::Refusal::kContradiction) break;
    }
    return result;
  }

  void closeAt(const Pose2& T_map_base, const SensorEvent& event, Resumption& result) {
    const auto start = std::chrono::steady_clock::now();
    ObservationSet set = *usableSet(event);
    begin(set);
    ++result.scans;
    const Eigen::Vector2d before = VehicleState::pose(estimate_.filter).position();
    const auto closing = path_closing_.tryClose(set, T_map_base, estimate_.vehicle,
                                                life_cycle_.registry(), estimate_.filter);
    if (!closing) return;
    result.closed_s = set.time_s;
    result.closing_pairs = closing->pairs();
    result.chi_square = closing->chi_square;
    result.inflation = closing->inflation;
    if (!closing->accepted()) {
      result.refusal = Resumption::Refusal::kContradiction;
      result.reason = std::to_string(closing->pairs()) +
                      " landmarks seen from the path contradict "
                      "the covariances: chi-square " +
                      std::to_string(closing->chi_square) + " of at most " +
                      std::to_string(closing->limit) + ", with the pose's taken " +
                      std::to_string(closing->inflation) + " times.";
      return;
    }
    estimate_.filter.setVehicleState(2, wrapAngle(estimate_.filter.vehicle()[2]));
    ScanOutcome outcome;
    outcome.health.nis = closing->update.nis;
    outcome.health.dof = 2 * closing->pairs();
    outcome.largest_correction_m = closing->update.largest_landmark_move_m;
    result.correction_m = (VehicleState::pose(estimate_.filter).position() - before).norm();
    result.refusal = Resumption::Refusal::kNotRefused;
    result.reason = "The loop was closed by " + std::to_string(closing->pairs()) +
                    " landmarks, which moved the vehicle by " +
                    std::to_string(result.correction_m) + " m.";
    const auto* scan = std::get_if<ScanEvent>(&event);
    finish(std::move(set), scan ? &scan->scan : nullptr, closing->association, true, start,
           outcome);
  }

  /// What a set of observations does to the landmarks beside the update. `scan`: that shows what
  /// was missed; null if it does not, or if the update was refused.
  void extendMap(const ObservationSet& set, const LaserScan* scan, const SensorPlacement& sensor,
                 const ScanAssociation& association, ScanOutcome& outcome) {
    life_cycle_.confirm(set, association, estimate_.filter);
    const std::vector<int> created = life_cycle_.create(
        set, sensor, association, estimate_.vehicle.linearisedAt(), estimate_.filter);
    const int missed =
        scan != nullptr ? life_cycle_.miss(*scan, set, sensor, association, estimate_.filter) : 0;
    countObservations(association, created, missed, outcome);
    outcome.largest_correction_m =
        std::max({outcome.largest_correction_m, life_cycle_.merge(association, estimate_.filter),
                  life_cycle_.closeLoop(set.time_s, estimate_.filter)});
    life_cycle_.refreshActive(estimate_.filter);
  }

  void refuseUnusable(ObservationSet& set) {
    auto& observations = set.observations;
    const auto bad = std::remove_if(observations.begin(), observations.end(),
                                    [](const Observation& o) { return !isUsable(o); });
    counts_.refused_observations += static_cast<std::size_t>(observations.end() - bad);
    observations.erase(bad, observations.end());
  }

  SensorPlacement sensorPlacement(const ObservationSet& set) const {
    return estimate_.vehicle.placement(set.T_base_sensor, estimate_.filter.vehicle());
  }

  /// False, and nothing is associated, if the update was refused.
  bool update(const ObservationSet& set, ScanAssociation& association, ScanOutcome& outcome) {
    if (association.measurements.empty()) return true;
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
    return true;
  }

  void countObservations(const ScanAssociation& association, const std::vector<int>& created,
                         int missed, ScanOutcome& outcome) {
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
  Eigen::Matrix3d covarianceAmongSeen(const ScanAssociation& association) const {
    std::vector<int> seen;
    for (const int slot : association.slots) {
      const bool is_there = slot != ScanAssociation::kNone && estimate_.filter.isActive(slot);
      if (is_there) seen.push_back(slot);  // else it was merged into another, or dropped
    }
    return relativeCovariance(estimate_.filter, seen);
  }

  void describeHealth(double time_s, std::chrono::steady_clock::time_point start,
                      ScanOutcome& outcome) const {
    FilterHealth& health = outcome.health;
    health.time_s = time_s;
    const Eigen::Matrix3d& P = outcome.pose.covariance;
    health.position_deviation_m = std::sqrt(std::max(P(0, 0), P(1, 1)));
    health.heading_deviation_rad = std::sqrt(P(2, 2));
    const std::chrono::duration<double, std::milli> elapsed =
        std::chrono::steady_clock::now() - start;
    health.latency_ms = elapsed.count();
  }

  /// What a large correction has moved is looked for in its new place at once, and carried to all.
  void spreadCorrection() {
    ++counts_.map_corrections;
    life_cycle_.refreshNear(VehicleState::pose(estimate_.filter).position(), kRefreshRadius_m,
                            estimate_.filter);
    area_.demandUpdate();
  }

  /// Takes over what a global update that is done has made of the passive landmarks.
  void refreshIfSettled() {
    if (estimate_.filter.isGlobalUpdatePending()) return;
    if (estimate_.filter.globalUpdatesDone() == settled_updates_) return;
    settled_updates_ = estimate_.filter.globalUpdatesDone();
    life_cycle_.refreshSettled(estimate_.filter);
  }

  void keepActiveArea() {
    const double worker_s = estimate_.filter.workerCpu_s();
    if (area_.follow(VehicleState::pose(estimate_.filter).position())) {
      const bool drops = use_ == MapUse::kExtend;
      if (drops) life_cycle_.dropUnconfirmed(last_scan_s_, estimate_.filter);
    }
    refreshIfSettled();
    area_.updateIfDue(estimate_.filter);
    refreshIfSettled();
    inline_worker_s_ += estimate_.filter.workerCpu_s() - worker_s;
  }

  CekfSlamConfig config_;
  VehicleConfig vehicle_config_;
  GlobalUpdates global_updates_;
  Perception perception_;
  ScanAssociator associator_;
  ScanUpdate scan_update_;
  LandmarkLifeCycle life_cycle_;
  LandmarkPins pins_;
  ActiveArea area_;
  PathClosing path_closing_;
  LocalStateRing ring_;
  Estimate estimate_;
  std::optional<Waiting> waiting_;  ///< while suspended
  bool replaying_ = false;
  std::size_t settled_updates_ = 0;  ///< global updates whose places life_cycle_ knows
  std::uint64_t version_ = 0;
  std::uint64_t told_version_ = 0;  ///< up to which takeUpdate() has told
  double last_scan_s_ = -std::numeric_limits<double>::infinity();
  MapUse use_ = MapUse::kExtend;
  bool is_just_loaded_ = false;
  std::size_t past_gaps_ = 0;
  double past_worker_s_ = 0.0;
  double inline_worker_s_ = 0.0;  ///< of global updates, within filter_s
  Counts counts_;
  CpuTimes cpu_times_;
};

CekfSlam::CekfSlam(const CekfSlamConfig& config, const VehicleConfig& vehicle,
                   GlobalUpdates global_updates)
    : impl_(std::make_unique<Impl>(config, vehicle, global_updates)) {}
CekfSlam::~CekfSlam() = default;
CekfSlam::CekfSlam(CekfSlam&&) noexcept = default;
CekfSlam& CekfSlam::operator=(CekfSlam&&) noexcept = default;

std::optional<ScanOutcome> CekfSlam::process(const SensorEvent& event) {
  return impl_->process(event);
}

void CekfSlam::reset() { impl_->reset(); }
PoseEstimate CekfSlam::pose() const { return impl_->pose(); }
Calibration CekfSlam::calibration() const { return impl_->calibration(); }
Eigen::Matrix3d CekfSlam::calibrationCovariance() const { return impl_->calibrationCovariance(); }
LaserCalibration CekfSlam::laserCalibration() const { return impl_->laserCalibration(); }
std::uint64_t CekfSlam::mapVersion() const { return impl_->version(); }
std::size_t CekfSlam::landmarkCount() const { return impl_->landmarkCount(); }
void CekfSlam::requestMap(double block_range_m, std::function<void(LandmarkMap)> take) {
  impl_->requestMap(block_range_m, std::move(take));
}
LandmarkMap CekfSlam::landmarkMap(double range_m) { return impl_->landmarkMap(range_m); }
bool CekfSlam::hasLandmark(int id) const { return impl_->hasLandmark(id); }
bool CekfSlam::requestJointLandmarks(const std::vector<int>& ids,
                                     std::function<void(JointLandmarks)> take) {
  return impl_->requestJointLandmarks(ids, std::move(take));
}
bool CekfSlam::requestVehicleAmongLandmarks(const std::vector<int>& ids,
                                            std::function<void(VehicleAmongLandmarks)> take) {
  return impl_->requestVehicleAmongLandmarks(ids, std::move(take));
}
void CekfSlam::keepLocalStates(int scans) { impl_->keepLocalStates(scans); }
std::optional<LocalStateSpan> CekfSlam::localStates() const { return impl_->localStates(); }
bool CekfSlam::suspend(double time_T0_s) { return impl_->suspend(time_T0_s); }
bool CekfSlam::isSuspended() const { return impl_->isSuspended(); }
Resumption CekfSlam::resume(double time_T0_s, const std::vector<PlaceAtScan>& path) {
  return impl_->resume(time_T0_s, path, false);
}
Resumption CekfSlam::resumeElsewhere(double time_T0_s, const std::vector<PlaceAtScan>& path) {
  return impl_->resume(time_T0_s, path, true);
}
Resumption CekfSlam::resumeWithoutClosing(double time_T0_s) {
  return impl_->resumeWithoutClosing(time_T0_s);
}
LandmarkUpdate CekfSlam::takeUpdate() { return impl_->takeUpdate(); }
void CekfSlam::pinLandmarks(double time_s, const std::vector<int>& ids) {
  impl_->pinLandmarks(time_s, ids);
}
std::string CekfSlam::saveState() { return impl_->saveState(); }
void CekfSlam::loadState(std::string_view bytes, const std::string& name, MapUse use) {
  impl_->loadState(bytes, name, use);
}
void CekfSlam::checkState(std::string_view bytes, const std::string& name) const {
  impl_->checkState(bytes, name);
}
void CekfSlam::placeVehicle(const Pose2& T_map_base, const Eigen::Matrix3d& covariance) {
  impl_->placeVehicle(T_map_base, covariance);
}
bool CekfSlam::isGlobalUpdatePending() { return impl_->isGlobalUpdatePending(); }
CekfSlam::Counts CekfSlam::counts() const { return impl_->counts(); }
CekfSlam::CpuTimes CekfSlam::cpuTimes() const { return impl_->cpuTimes(); }

}  // namespace hymm::core
