#include "cekf/cekf_slam.h"

#include <future>
#include <utility>

#include "cekf/landmark_slam.h"
#include "cekf/way_back.h"

namespace hymm::core {

class CekfSlam::Impl {
 public:
  Impl(const CekfSlamConfig& config, const VehicleConfig& vehicle, GlobalUpdates global_updates)
      : slam(config, vehicle, global_updates), way_back(slam, config) {}

  void reset() {
    way_back.reset();
    slam.reset();
  }

  LandmarkSlam slam;
  WayBack way_back;
};

CekfSlam::CekfSlam(const CekfSlamConfig& config, const VehicleConfig& vehicle,
                   GlobalUpdates global_updates)
    : impl_(std::make_unique<Impl>(config, vehicle, global_updates)) {}
CekfSlam::~CekfSlam() = default;
CekfSlam::CekfSlam(CekfSlam&&) noexcept = default;
CekfSlam& CekfSlam::operator=(CekfSlam&&) noexcept = default;

std::optional<ScanOutcome> CekfSlam::process(const SensorEvent& event) {
  if (!std::holds_alternative<ClockReset>(event)) return impl_->way_back.process(event);
  impl_->reset();
  return std::nullopt;
}

void CekfSlam::reset() { impl_->reset(); }

PoseEstimate CekfSlam::pose() const {
  return impl_->way_back.isSuspended() ? impl_->way_back.pose() : impl_->slam.pose();
}
Calibration CekfSlam::calibration() const { return impl_->slam.calibration(); }
Eigen::Matrix3d CekfSlam::calibrationCovariance() const {
  return impl_->slam.calibrationCovariance();
}
LaserCalibration CekfSlam::laserCalibration() const { return impl_->slam.laserCalibration(); }
Eigen::Vector2d CekfSlam::motionNoiseFactors() const { return impl_->slam.motionNoiseFactors(); }
std::uint64_t CekfSlam::mapVersion() const { return impl_->slam.version(); }
std::size_t CekfSlam::landmarkCount() const { return impl_->slam.landmarkCount(); }
bool CekfSlam::hasLandmark(int id) const { return impl_->slam.hasLandmark(id); }

void CekfSlam::requestMap(double block_range_m, std::function<void(LandmarkMap)> take) {
  impl_->slam.requestMap(block_range_m, std::move(take));
}

LandmarkMap CekfSlam::landmarkMap(double block_range_m) {
  // Held by the job alone: should that fail, get() throws.
  auto promise = std::make_shared<std::promise<LandmarkMap>>();
  std::future<LandmarkMap> map = promise->get_future();
  requestMap(block_range_m, [promise = std::move(promise)](LandmarkMap made) {
    promise->set_value(std::move(made));
  });
  return map.get();
}

bool CekfSlam::requestJointLandmarks(const std::vector<int>& ids,
                                     std::function<void(JointLandmarks)> take) {
  return impl_->slam.requestJointLandmarks(ids, std::move(take));
}
bool CekfSlam::requestVehicleAmongLandmarks(const std::vector<int>& ids,
                                            std::function<void(VehicleAmongLandmarks)> take) {
  return impl_->slam.requestVehicleAmongLandmarks(ids, std::move(take));
}

void CekfSlam::keepLocalStates(double duration_s) { impl_->way_back.keepLocalStates(duration_s); }
std::optional<LocalStateSpan> CekfSlam::localStates() const {
  return impl_->way_back.localStates();
}
bool CekfSlam::suspend(double time_T0_s) { return impl_->way_back.suspend(time_T0_s); }
bool CekfSlam::isSuspended() const { return impl_->way_back.isSuspended(); }
Resumption CekfSlam::resume(double time_T0_s, const std::vector<PlaceAtScan>& path) {
  return impl_->way_back.resume(time_T0_s, path, false);
}
Resumption CekfSlam::resumeElsewhere(double time_T0_s, const std::vector<PlaceAtScan>& path) {
  return impl_->way_back.resume(time_T0_s, path, true);
}
Resumption CekfSlam::resumeWithoutClosing(double time_T0_s) {
  return impl_->way_back.resumeWithoutClosing(time_T0_s);
}

LandmarkUpdate CekfSlam::takeUpdate() { return impl_->slam.takeUpdate(); }
void CekfSlam::pinLandmarks(double time_s, const std::vector<int>& ids) {
  impl_->slam.pinLandmarks(time_s, ids);
}

std::string CekfSlam::saveState() { return impl_->slam.saveState(); }
void CekfSlam::loadState(std::string_view bytes, const std::string& name, MapUse use) {
  impl_->slam.loadState(bytes, name, use);
  impl_->way_back.reset();
}
void CekfSlam::checkState(std::string_view bytes, const std::string& name) const {
  impl_->slam.checkState(bytes, name);
}
void CekfSlam::placeVehicle(const Pose2& T_map_base, const Eigen::Matrix3d& covariance) {
  impl_->slam.placeVehicle(T_map_base, covariance);
}
bool CekfSlam::isGlobalUpdatePending() { return impl_->slam.filter().isGlobalUpdatePending(); }
CekfSlam::Counts CekfSlam::counts() const { return impl_->slam.counts(); }
CekfSlam::CpuTimes CekfSlam::cpuTimes() const { return impl_->slam.cpuTimes(); }

}  // namespace hymm::core
