#include "cekf/cekf_slam.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>

#include "cekf/compressed_ekf.h"
#include "cekf/gps_datum.h"
#include "cekf/landmark_life_cycle.h"
#include "cekf/map_snapshot.h"
#include "cekf/scan_associator.h"
#include "common/gaussian.h"
#include "perception/perception.h"
#include "perception/scan_check.h"

namespace hymm::core {
namespace {

double threadCpuTime_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Adds the CPU time of its life to a sum.
class CpuTimer {
 public:
  explicit CpuTimer(double& sum_s) : sum_s_(sum_s), start_s_(threadCpuTime_s()) {}
  ~CpuTimer() { sum_s_ += threadCpuTime_s() - start_s_; }
  CpuTimer(const CpuTimer&) = delete;
  CpuTimer& operator=(const CpuTimer&) = delete;

 private:
  double& sum_s_;
  double start_s_;
};

bool isUsable(const Observation& observation) {
  return std::isfinite(observation.range_m) && observation.range_m > 0.0 &&
         std::isfinite(observation.bearing_rad) && isCovariance(observation.covariance);
}

double share(int part, int whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

}  // namespace

class CekfSlam::Impl {
 public:
  Impl(const CekfSlamConfig& config, const VehicleConfig& vehicle)
      : config_(config),
        vehicle_config_(vehicle),
        perception_(config.perception),
        associator_(config.association),
        life_cycle_(config.landmarks),
        estimate_(newEstimate()) {}

  void takeMotion(const MotionInput& input) {
    const CpuTimer timer(cpu_times_.filter_s);
    if (!estimate_.vehicle.takeInput(estimate_.filter, input)) ++counts_.refused_motion;
  }

  ScanOutcome processScan(const ScanEvent& event) {
    const auto start = std::chrono::steady_clock::now();
    if (const auto problem = scanProblem(event.scan)) return refuse(*problem);
    if (event.scan.time_s <= last_scan_s_) return refuse("the scan is not later than the last one");
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
    if (set.time_s <= last_scan_s_) {
      return refuse("the observations are not later than the last ones");
    }
    return processSet(set, nullptr, start);
  }

  void processGps(const GpsFix& fix) {
    if (!estimate_.gps) return;
    const CpuTimer timer(cpu_times_.filter_s);
    const bool usable = std::isfinite(fix.time_s) && fix.position.allFinite() &&
                        isCovariance(fix.covariance) && fix.antenna.allFinite();
    if (usable) estimate_.vehicle.moveTo(estimate_.filter, fix.time_s);
    const bool was_aligned = estimate_.gps->isAligned();
    if (usable && estimate_.gps->process(fix, estimate_.filter)) {
      ++counts_.gps_used;
    } else if (!usable || was_aligned) {
      ++counts_.gps_rejected;
    }
  }

  void reset() {
    ++counts_.resets;
    life_cycle_.setVersion(++version_);
    life_cycle_.clear();
    past_gaps_ += estimate_.vehicle.gaps();
    estimate_ = newEstimate();
    last_scan_s_ = -std::numeric_limits<double>::infinity();
  }

  PoseEstimate pose() const {
    PoseEstimate pose;
    pose.time_s = estimate_.vehicle.time_s();
    pose.T_map_base = VehicleState::pose(estimate_.filter);
    pose.covariance = estimate_.filter.vehicleCovariance().topLeftCorner<3, 3>();
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

  LandmarkMap landmarkMap(double block_range_m) const {
    LandmarkMap map = snapshotOf(life_cycle_.registry(), estimate_.filter, block_range_m);
    map.version = version_;
    map.time_s = estimate_.vehicle.time_s();
    map.merges = life_cycle_.merges();
    return map;
  }

  LandmarkUpdate updateSince(std::uint64_t since) const {
    LandmarkUpdate update;
    update.since_version = since;
    update.version = version_;
    const LandmarkRegistry& registry = life_cycle_.registry();
    for (const int id : registry.ids()) {
      const RegisteredLandmark& landmark = registry.byId(id);
      if (landmark.changed_version <= since) continue;
      update.changed.push_back(estimateOf(landmark, estimate_.filter));
    }
    for (const auto& [version, id] : life_cycle_.removals()) {
      if (version > since) update.removed_ids.push_back(id);
    }
    update.merges = life_cycle_.merges();
    return update;
  }

  const Counts& counts() const {
    counts_.motion_gaps = past_gaps_ + estimate_.vehicle.gaps();
    counts_.landmarks_created = life_cycle_.counts().created;
    counts_.landmarks_dropped = life_cycle_.counts().dropped;
    counts_.landmarks_merged = life_cycle_.counts().merged;
    return counts_;
  }
  const CpuTimes& cpuTimes() const { return cpu_times_; }

 private:
  /// What begins anew with each recording.
  struct Estimate {
    VehicleState vehicle;
    CompressedEkf filter;
    std::optional<GpsDatum> gps;
    Eigen::Vector2d area_centre = Eigen::Vector2d::Zero();
  };

  Estimate newEstimate() const {
    VehicleState vehicle(vehicle_config_, config_.motion_input == "odom", config_.gps.enabled);
    CompressedEkf filter(vehicle.initialState(), vehicle.initialCovariance());
    Estimate estimate{vehicle, std::move(filter), std::nullopt, Eigen::Vector2d::Zero()};
    if (config_.gps.enabled) estimate.gps.emplace(config_.gps, vehicle.gpsDatumIndex());
    return estimate;
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
    ScanOutcome outcome;
    outcome.accepted = true;
    refuseUnusable(set);
    last_scan_s_ = set.time_s;
    life_cycle_.setVersion(++version_);
    if (!estimate_.vehicle.hasInput()) ++counts_.scans_without_motion;
    estimate_.vehicle.moveTo(estimate_.filter, set.time_s);

    SensorPlacement sensor = estimate_.vehicle.placement(set.T_base_sensor, estimate_.filter);
    ScanAssociation association =
        associator_.associate(set, sensor, life_cycle_.registry(), estimate_.filter);
    outcome.health = update(association);
    sensor = estimate_.vehicle.placement(set.T_base_sensor, estimate_.filter);
    life_cycle_.confirm(set, association);
    const std::vector<int> created = life_cycle_.create(set, sensor, association, estimate_.filter);
    const int missed =
        scan != nullptr ? life_cycle_.miss(*scan, set, sensor, association, estimate_.filter) : 0;
    countObservations(association, created, missed, outcome);
    outcome.largest_correction_m = life_cycle_.refreshActive(estimate_.filter);
    life_cycle_.merge(association, estimate_.filter);
    moveActiveArea(outcome.largest_correction_m);

    ++counts_.scans;
    outcome.pose = pose();
    outcome.pose.time_s = set.time_s;
    describeHealth(set.time_s, start, outcome);
    outcome.observations = std::move(set);
    return outcome;
  }

  void refuseUnusable(ObservationSet& set) {
    auto& observations = set.observations;
    const auto bad = std::remove_if(observations.begin(), observations.end(),
                                    [](const Observation& o) { return !isUsable(o); });
    counts_.refused_observations += static_cast<std::size_t>(observations.end() - bad);
    observations.erase(bad, observations.end());
  }

  FilterHealth update(ScanAssociation& association) {
    FilterHealth health;
    if (association.measurements.empty()) return health;
    const double nis = estimate_.filter.update(association.measurements).nis;
    if (!std::isfinite(nis)) {
      association.slots.assign(association.slots.size(), ScanAssociation::kNone);
      return health;
    }
    const Eigen::VectorXd state = estimate_.filter.vehicle();
    estimate_.filter.setVehicleState(2, wrapAngle(state[2]));
    health.nis = nis;
    health.dof = 2 * static_cast<int>(association.measurements.size());
    return health;
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
    counts_.observations += association.slots.size();
    counts_.associated += static_cast<std::size_t>(associated);
    outcome.health.ambiguity = share(association.ambiguous, n);
    outcome.health.unexplained = share(unexplained, n);
    outcome.health.missed = share(missed, missed + associated);
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

  /// Global update when the vehicle has left its cell, when the active part has grown too large, or
  /// when a correction would otherwise shear the map at the border of the active part.
  void moveActiveArea(double correction_m) {
    const bool corrected = correction_m > config_.large_correction_m;
    if (corrected) ++counts_.map_corrections;
    const ActiveAreaConfig& area = config_.active_area;
    const Eigen::Vector2d position = VehicleState::pose(estimate_.filter).position();
    const double away = (position - estimate_.area_centre).cwiseAbs().maxCoeff();
    const bool left = away > 0.5 * area.cell_m + area.hysteresis_m;
    const bool full = estimate_.filter.originStates() > area.max_origin_states;
    if (!left && !full && !corrected) return;
    if (left) {
      estimate_.area_centre = (position / area.cell_m).array().round() * area.cell_m;
      ++counts_.area_switches;
      life_cycle_.dropUnconfirmed(last_scan_s_, estimate_.filter);
    }
    estimate_.filter.globalUpdate();
    life_cycle_.refreshAll(estimate_.filter);
  }

  CekfSlamConfig config_;
  VehicleConfig vehicle_config_;
  Perception perception_;
  ScanAssociator associator_;
  LandmarkLifeCycle life_cycle_;
  Estimate estimate_;
  std::uint64_t version_ = 0;
  double last_scan_s_ = -std::numeric_limits<double>::infinity();
  std::size_t past_gaps_ = 0;
  mutable Counts counts_;
  CpuTimes cpu_times_;
};

CekfSlam::CekfSlam(const CekfSlamConfig& config, const VehicleConfig& vehicle)
    : impl_(std::make_unique<Impl>(config, vehicle)) {}
CekfSlam::~CekfSlam() = default;
CekfSlam::CekfSlam(CekfSlam&&) noexcept = default;
CekfSlam& CekfSlam::operator=(CekfSlam&&) noexcept = default;

std::optional<ScanOutcome> CekfSlam::process(const SensorEvent& event) {
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
  return std::visit(Visitor{*impl_}, event);
}

void CekfSlam::reset() { impl_->reset(); }
PoseEstimate CekfSlam::pose() const { return impl_->pose(); }
Calibration CekfSlam::calibration() const { return impl_->calibration(); }
Eigen::Matrix3d CekfSlam::calibrationCovariance() const { return impl_->calibrationCovariance(); }
LaserCalibration CekfSlam::laserCalibration() const { return impl_->laserCalibration(); }
std::uint64_t CekfSlam::mapVersion() const { return impl_->version(); }
std::size_t CekfSlam::landmarkCount() const { return impl_->landmarkCount(); }
LandmarkMap CekfSlam::landmarkMap(double range_m) const { return impl_->landmarkMap(range_m); }
LandmarkUpdate CekfSlam::updateSince(std::uint64_t version) const {
  return impl_->updateSince(version);
}
const CekfSlam::Counts& CekfSlam::counts() const { return impl_->counts(); }
const CekfSlam::CpuTimes& CekfSlam::cpuTimes() const { return impl_->cpuTimes(); }

}  // namespace hymm::core
