#include "cekf/sight.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "common/cpu_timer.h"
#include "common/gaussian.h"
#include "perception/scan_check.h"
#include "perception/swept_scan.h"

namespace hymm::core {
namespace {

// Of a diameter's variance, what rounding may take away once range and bearing are given.
constexpr double kRounding = 1e-9;

/// Of an observation whose range and bearing are in order, the diameter and its covariance with
/// them.
bool isDiameterUsable(const Observation& observation) {
  const double diameter_m = observation.diameter_m, variance = observation.diameter_variance;
  if (std::isnan(diameter_m)) return true;
  if (!(diameter_m >= 0.0) || std::isinf(diameter_m)) return false;
  if (std::isnan(variance)) return true;
  const Eigen::Vector2d& cross = observation.diameter_covariance;
  const double explained = cross.dot(observation.covariance.inverse() * cross);
  return std::isfinite(variance) && explained <= (1.0 + kRounding) * variance;
}

bool isUsable(const Observation& observation) {
  return std::isfinite(observation.range_m) && observation.range_m > 0.0 &&
         std::isfinite(observation.bearing_rad) && isCovariance(observation.covariance) &&
         isDiameterUsable(observation);
}

}  // namespace

Sight Sight::of(const SensorEvent& event, const Perception& perception, double& perception_s) {
  Sight sight;
  if (const auto* observed = std::get_if<ObservationSet>(&event)) {
    if (std::isfinite(observed->time_s)) {
      sight.set = *observed;
    } else {
      sight.refuse("the observations' time is not finite");
    }
  } else if (const auto* measured = std::get_if<ScanEvent>(&event)) {
    if (const auto found = scanProblem(measured->scan)) {
      sight.refuse(*found);
      return sight;
    }
    const CpuTimer timer(perception_s);
    sight.scan = &measured->scan;
    sight.motion_meanwhile = &measured->motion_meanwhile;
    sight.set.emplace();
    sight.set->time_s = measured->scan.time_s;
    sight.set->T_base_sensor = measured->T_base_laser;
    sight.set->observations = perception.detect(measured->scan);
  }
  return sight;
}

void Sight::refuse(std::string reason) {
  set.reset();
  problem = std::move(reason);
}

void Sight::mustBeNewTo(const ScanClock& clock) {
  if (!set || clock.takes(set->time_s, set->T_base_sensor)) return;
  refuse(scan != nullptr ? "the scan is not later than the last one"
                         : "the observations are not later than the last ones");
}

std::size_t Sight::dropUnusable() {
  auto& observations = set->observations;
  const auto bad = std::remove_if(observations.begin(), observations.end(),
                                  [](const Observation& seen) { return !isUsable(seen); });
  const auto dropped = static_cast<std::size_t>(observations.end() - bad);
  observations.erase(bad, observations.end());
  return dropped;
}

void Sight::undoSweep(const VehicleState& vehicle, const CompressedEkf& filter) {
  if (scan == nullptr || scan->sweep_s() == 0.0) return;
  sweep = vehicle.motionFrom(filter, *motion_meanwhile);
  if (sweep.isStill()) return;
  const Pose2 T_base_sensor = vehicle.placement(set->T_base_sensor, filter.vehicle()).T_base_sensor;
  for (Observation& seen : set->observations) {
    const double after_s = seen.after_stamp_s;
    seen = asOfStamp(seen, sweep.sensorPoseAfter(after_s, T_base_sensor),
                     sweep.sensorCovarianceAfter(after_s, T_base_sensor));
  }
  swept = std::make_shared<const LaserScan>(sweptScan(*scan, sweep, T_base_sensor));
  scan = swept.get();
}

}  // namespace hymm::core
