#include "cekf/way_back.h"

#include <chrono>
#include <cmath>
#include <utility>

#include "common/cpu_timer.h"

namespace hymm::core {
namespace {

// Of a vehicle that was carried: far beyond what particles that have converged leave open, and what
// a scan's way is.
constexpr double kElsewhereDeviation_m = 5.0;
constexpr double kElsewhereDeviation_rad = 0.3;

// Stamps that have gone through a message or a file may differ by rounding.
constexpr double kSameStamp_s = 1e-4;

std::string pathProblem(double time_T0_s, const std::vector<PlaceAtScan>& path) {
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

std::string contradictionText(const PathClosing::Closing& closing) {
  return std::to_string(closing.pairs()) +
         " landmarks seen from the path contradict the covariances: chi-square " +
         std::to_string(closing.chi_square) + " of at most " + std::to_string(closing.limit) +
         ", with the pose's taken " + std::to_string(closing.inflation) + " times.";
}

}  // namespace

WayBack::WayBack(LandmarkSlam& slam, const CekfSlamConfig& config)
    : slam_(slam),
      least_pairs_(config.resumption.least_pairs),
      closing_(config.resumption, config.update.atFirstEstimates()) {}

std::optional<ScanOutcome> WayBack::process(const SensorEvent& event) {
  ring_.add(event);
  return apply(event);
}

void WayBack::reset() {
  waiting_.reset();
  ring_.clear();
}

std::optional<ScanOutcome> WayBack::apply(const SensorEvent& event) {
  if (waiting_) return wait(event);
  std::optional<ScanOutcome> outcome = slam_.process(event);
  if (outcome && outcome->accepted) keepLocalState();
  return outcome;
}

// --- Waiting ---------------------------------------------------------------------------------

std::optional<ScanOutcome> WayBack::wait(const SensorEvent& event) {
  if (const auto* input = std::get_if<MotionInput>(&event)) {
    const CpuTimer timer(slam_.filterCpu_s());
    const bool taken = waiting_->vehicle.takeInput(waiting_->filter, *input);
    if (!taken) ++slam_.eventCounts().refused_motion;
    return std::nullopt;
  }
  if (std::holds_alternative<GpsFix>(event)) return std::nullopt;
  const auto start = std::chrono::steady_clock::now();
  Sight sight = slam_.see(event);
  sight.mustBeNewTo(waiting_->scan_clock);
  if (!sight.set) return slam_.refuse(sight);
  const CpuTimer timer(slam_.filterCpu_s());
  return waitThrough(std::move(sight), start);
}

/// A scan while the filter waits: the vehicle goes on by its motion.
ScanOutcome WayBack::waitThrough(Sight sight, LandmarkSlam::Instant start) {
  ScanOutcome outcome;
  outcome.accepted = outcome.suspended = true;
  slam_.refuseUnusable(sight);
  ObservationSet& set = *sight.set;
  waiting_->scan_clock.note(set.time_s, set.T_base_sensor);
  waiting_->vehicle.moveTo(waiting_->filter, set.time_s);
  sight.undoSweep(waiting_->vehicle, waiting_->filter);
  CekfSlam::Counts& counts = slam_.eventCounts();
  if (!replaying_) {
    counts.forgotten_states += ring_.dropScansBefore(set.time_s - CekfSlam::kLongestSuspension_s);
  }
  ++counts.scans;
  counts.observations += set.observations.size();
  outcome.associations.resize(set.observations.size());
  outcome.pose = pose();
  tellSensor(waiting_->vehicle.placement(set.T_base_sensor, waiting_->filter.vehicle()),
             outcome.pose);
  outcome.pose.sweep = std::move(sight.sweep);
  describeHealth(set.time_s, start, outcome);
  outcome.observations = std::move(set);
  return outcome;
}

PoseEstimate WayBack::pose() const {
  PoseEstimate pose;
  pose.time_s = waiting_->vehicle.time_s();
  pose.T_map_base = VehicleState::pose(waiting_->filter);
  pose.covariance = waiting_->filter.vehicleCovariance().topLeftCorner<3, 3>();
  pose.relative_covariance = pose.covariance;
  pose.map_version = slam_.version();
  return pose;
}

// --- Local states ----------------------------------------------------------------------------

void WayBack::keepLocalStates(double duration_s) {
  if (waiting_) return;
  ring_.setDuration(duration_s);
  slam_.holdGlobalUpdates(ring_.isKept());
}

/// After a scan: what can be gone back to, and what need not be held back any more.
void WayBack::keepLocalState() {
  if (!ring_.isKept() || replaying_) return;
  const CpuTimer timer(slam_.filterCpu_s());
  CompressedEkf& filter = slam_.filter();
  slam_.eventCounts().forgotten_states += ring_.giveUp(
      [&filter](const FilterMemory& memory) { return filter.canGoBackTo(memory.filter); });
  if (ring_.noteScan(slam_.lastScan_s())) ring_.remember(slam_.remembered());
  if (filter.isGlobalUpdateHeldSince(ring_.oldest()->filter)) filter.releaseGlobalUpdate();
}

std::optional<LocalStateRing::Way> WayBack::findWay(double time_s) const {
  auto way = ring_.findWay(time_s);
  const bool is_open = way && slam_.filter().canGoBackTo(way->memory->filter);
  return is_open ? std::move(way) : std::nullopt;
}

/// Goes back to a memory, and from there to a scan: the same way, to the bit.
void WayBack::goAlong(const LocalStateRing::Way& way) {
  LandmarkLifeCycle& life_cycle = slam_.lifeCycle();
  const int next_id = life_cycle.nextId();
  waiting_.reset();
  slam_.recall(*way.memory);
  life_cycle.goBackTo(way.memory->life_cycle);
  replay(way.to_scan);
  life_cycle.skipIds(next_id);  // those that were given out since mean other landmarks
}

/// Each event counts once, when it comes.
void WayBack::replay(const LocalStateRing::Events& events) {
  const CekfSlam::Counts counts = slam_.eventCounts();
  const bool was_replaying = std::exchange(replaying_, true);
  for (const auto& event : events) apply(*event);
  replaying_ = was_replaying;
  slam_.eventCounts() = counts;
}

bool WayBack::suspend(double time_T0_s) {
  const auto way = findWay(time_T0_s);
  if (!way) return false;
  goAlong(*way);
  slam_.setVersion(slam_.version() + 1);
  ring_.goBackTo(*way, slam_.remembered());
  const CompressedEkf& filter = slam_.filter();
  waiting_.emplace(Waiting{slam_.vehicle(),
                           CompressedEkf(filter.vehicle(), filter.vehicleCovariance()),
                           slam_.scanClock()});
  replay(way->since);
  return true;
}

// --- On again --------------------------------------------------------------------------------

/// Goes back to the scan at T0 and on from there by `go`. If that refuses, nothing has happened.
template <typename Go>
Resumption WayBack::goBackAndOn(double time_T0_s, Go go) {
  const auto way = findWay(time_T0_s);
  if (!way) return refuse(Resumption::Refusal::kNotKept, notKept(time_T0_s));
  const LocalStateRing::Memory now = slam_.remembered();
  const std::uint64_t version = slam_.version();
  const CekfSlam::Counts counts = slam_.eventCounts();
  std::optional<Waiting> waiting = std::move(waiting_);
  goAlong(*way);
  replaying_ = true;
  Resumption result = go(way->since);
  replaying_ = false;
  slam_.eventCounts() = counts;
  if (!result.accepted()) {
    slam_.recall(*now);
    slam_.lifeCycle() = now->life_cycle;
    slam_.setVersion(version);
    waiting_ = std::move(waiting);
    return refuse(result.refusal, result.reason);
  }
  ++slam_.eventCounts().resumed;
  slam_.setVersion(slam_.version() + 1);
  ring_.clear();
  if (ring_.isKept()) ring_.remember(slam_.remembered());
  return result;
}

Resumption WayBack::refuse(Resumption::Refusal refusal, const std::string& reason) {
  ++slam_.eventCounts().refused_resumptions;
  Resumption result;
  result.refusal = refusal;
  result.reason = reason;
  return result;
}

std::string WayBack::notKept(double time_T0_s) const {
  const auto span = ring_.span();
  const std::string asked = "There is no way back to a scan at " + std::to_string(time_T0_s);
  if (!span) return asked + " s: no local states are kept.";
  return asked + " s: those from " + std::to_string(span->oldest_s) + " to " +
         std::to_string(span->newest_s) + " s are kept.";
}

Resumption WayBack::resume(double time_T0_s, const std::vector<PlaceAtScan>& path, bool elsewhere) {
  const std::string problem = pathProblem(time_T0_s, path);
  if (!problem.empty()) return refuse(Resumption::Refusal::kUnusablePath, problem);
  return goBackAndOn(time_T0_s, [&](const LocalStateRing::Events& events) {
    if (elsewhere) beginElsewhere(path.front().T_map_base);
    return replayAlong(path, events);
  });
}

Resumption WayBack::resumeWithoutClosing(double time_T0_s) {
  return goBackAndOn(time_T0_s, [&](const LocalStateRing::Events& events) {
    Resumption result;
    for (const auto& event : events) moveAlong(*event, result);
    result.reason = "On by dead reckoning from " + std::to_string(time_T0_s) + " s over " +
                    std::to_string(result.scans) + " scans; no loop was closed.";
    return result;
  });
}

/// Gives up what the filter holds of the pose: as a motion that has forgotten where it came from.
void WayBack::beginElsewhere(const Pose2& T_map_base) {
  CompressedEkf& filter = slam_.filter();
  Eigen::VectorXd vehicle = filter.vehicle();
  vehicle.head<3>() = T_map_base.vector();
  Eigen::MatrixXd J = Eigen::MatrixXd::Identity(vehicle.size(), vehicle.size());
  Eigen::MatrixXd Q = Eigen::MatrixXd::Zero(vehicle.size(), vehicle.size());
  J.topLeftCorner<3, 3>().setZero();
  Q.diagonal().head<3>() << kElsewhereDeviation_m * kElsewhereDeviation_m,
      kElsewhereDeviation_m * kElsewhereDeviation_m,
      kElsewhereDeviation_rad * kElsewhereDeviation_rad;
  filter.predict(vehicle, J, Q);
  slam_.vehicle().linearisePositionAt(T_map_base.position());
}

/// What a kept event shows, if it can still be processed.
Sight WayBack::seeAgain(const SensorEvent& event) {
  Sight sight = slam_.see(event);
  sight.mustBeNewTo(slam_.scanClock());
  return sight;
}

/// An event that moves the vehicle only.
void WayBack::moveAlong(const SensorEvent& event, Resumption& result) {
  if (const auto* input = std::get_if<MotionInput>(&event)) slam_.takeMotion(*input);
  Sight sight = seeAgain(event);
  if (!sight.set) return;
  slam_.begin(sight);
  ++result.scans;
}

/// Closes the loop at the first scan that lets it, and processes as ever what follows.
Resumption WayBack::replayAlong(const std::vector<PlaceAtScan>& path,
                                const LocalStateRing::Events& events) {
  Resumption result;
  result.refusal = Resumption::Refusal::kNothingPlain;
  result.reason = "No scan of the path shows " + std::to_string(least_pairs_) +
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
    Sight sight;
    if (on_path) sight = seeAgain(event);
    if (!sight.set) {
      moveAlong(event, result);
      continue;
    }
    closeAt(place->T_map_base, std::move(sight), result);
    if (result.refusal == Resumption::Refusal::kContradiction) break;
  }
  return result;
}

void WayBack::closeAt(const Pose2& T_map_base, Sight sight, Resumption& result) {
  const auto start = std::chrono::steady_clock::now();
  slam_.begin(sight);
  const ObservationSet& set = *sight.set;
  ++result.scans;
  CompressedEkf& filter = slam_.filter();
  const Eigen::Vector2d before = VehicleState::pose(filter).position();
  const auto closing =
      closing_.tryClose(set, T_map_base, slam_.vehicle(), slam_.lifeCycle().registry(), filter);
  if (!closing) return;
  result.closed_s = set.time_s;
  result.closing_pairs = closing->pairs();
  result.chi_square = closing->chi_square;
  result.inflation = closing->inflation;
  if (!closing->accepted()) {
    result.refusal = Resumption::Refusal::kContradiction;
    result.reason = contradictionText(*closing);
    return;
  }
  filter.setVehicleState(2, wrapAngle(filter.vehicle()[2]));
  slam_.vehicle().beginMotionNoise();  // the scan is explained
  ScanOutcome outcome;
  outcome.health.nis = closing->update.nis;
  outcome.health.dof = 2 * closing->pairs();
  outcome.largest_correction_m = closing->update.largest_landmark_move_m;
  result.correction_m = (VehicleState::pose(filter).position() - before).norm();
  result.refusal = Resumption::Refusal::kNotRefused;
  result.reason = "The loop was closed by " + std::to_string(closing->pairs()) +
                  " landmarks, which moved the vehicle by " + std::to_string(result.correction_m) +
                  " m.";
  slam_.finish(std::move(sight), closing->association, true, start, outcome);
}

}  // namespace hymm::core
