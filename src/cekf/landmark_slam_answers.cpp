/// What LandmarkSlam tells of its estimate.
#include <algorithm>
#include <cmath>
#include <utility>

#include "cekf/landmark_requests.h"
#include "cekf/landmark_slam.h"
#include "cekf/map_snapshot.h"

namespace hymm::core {

PoseEstimate LandmarkSlam::pose() const {
  PoseEstimate pose;
  pose.time_s = estimate_.vehicle.time_s();
  pose.T_map_base = VehicleState::pose(estimate_.filter);
  pose.covariance = estimate_.filter.vehicleCovariance().topLeftCorner<3, 3>();
  pose.relative_covariance = pose.covariance;  // what is common to all is not told apart
  pose.map_version = version_;
  return pose;
}

void tellSensor(const SensorPlacement& sensor, PoseEstimate& pose) {
  pose.T_base_sensor = sensor.T_base_sensor;
  pose.range_offset_m = sensor.range_offset_m;
}

void describeHealth(double time_s, LandmarkSlam::Instant start, ScanOutcome& outcome) {
  FilterHealth& health = outcome.health;
  health.time_s = time_s;
  const Eigen::Matrix3d& P = outcome.pose.covariance;
  health.position_deviation_m = std::sqrt(std::max(P(0, 0), P(1, 1)));
  health.heading_deviation_rad = std::sqrt(P(2, 2));
  const std::chrono::duration<double, std::milli> elapsed =
      std::chrono::steady_clock::now() - start;
  health.latency_ms = elapsed.count();
}

Calibration LandmarkSlam::calibration() const {
  return estimate_.vehicle.calibration(estimate_.filter.vehicle());
}

Eigen::Matrix3d LandmarkSlam::calibrationCovariance() const {
  return estimate_.vehicle.calibrationCovariance(estimate_.filter.vehicleCovariance());
}

LaserCalibration LandmarkSlam::laserCalibration() const {
  return estimate_.vehicle.laserCalibration(estimate_.filter);
}

void LandmarkSlam::requestMap(double block_range_m, std::function<void(LandmarkMap)> take) {
  LandmarkMap header;
  header.version = version_;
  header.time_s = estimate_.vehicle.time_s();
  header.merges = life_cycle_.merges();
  core::requestMap(life_cycle_.registry(), std::move(header), block_range_m, estimate_.filter,
                   std::move(take));
}

bool LandmarkSlam::requestJointLandmarks(const std::vector<int>& ids,
                                         std::function<void(JointLandmarks)> take) {
  JointLandmarks header;
  header.version = version_;
  header.time_s = estimate_.vehicle.time_s();
  header.ids = ids;
  return core::requestJointLandmarks(life_cycle_.registry(), std::move(header), estimate_.filter,
                                     std::move(take));
}

bool LandmarkSlam::requestVehicleAmongLandmarks(const std::vector<int>& ids,
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

LandmarkUpdate LandmarkSlam::takeUpdate() {
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

void LandmarkSlam::placeVehicle(const Pose2& T_map_base, const Eigen::Matrix3d& covariance) {
  const Eigen::MatrixXd independent = Eigen::MatrixXd::Zero(3, estimate_.vehicle.size());
  estimate_.filter.initialiseVehicleStates(0, T_map_base.vector(), independent, covariance);
  estimate_.vehicle.linearisePositionAt(T_map_base.position());
  ++version_;
}

LandmarkSlam::Counts LandmarkSlam::counts() const {
  Counts counts = counts_;
  counts.motion_gaps = past_gaps_ + estimate_.vehicle.gaps();
  counts.landmarks_created = life_cycle_.counts().created;
  counts.landmarks_dropped = life_cycle_.counts().dropped;
  counts.landmarks_merged = life_cycle_.counts().merged;
  counts.slips += life_cycle_.counts().slips;
  counts.iterated_updates = scan_update_.iterated();
  counts.diverged_updates = scan_update_.diverged();
  counts.area_switches = area_.counts().switches;
  counts.global_updates = area_.counts().global_updates;
  counts.deferred_global_updates = area_.counts().deferred;
  counts.global_update_waits = area_.counts().waits;
  return counts;
}

LandmarkSlam::CpuTimes LandmarkSlam::cpuTimes() const {
  CpuTimes times = cpu_times_;
  times.worker_s = past_worker_s_ + estimate_.filter.workerCpu_s();
  // What an inline worker does after the last scan is not in the filter's time.
  if (global_updates_ == CekfSlam::GlobalUpdates::kInline) times.filter_s -= inline_worker_s_;
  return times;
}

}  // namespace hymm::core
