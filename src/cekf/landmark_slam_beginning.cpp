/// How LandmarkSlam begins a map: as it is made, anew, and with the first motion.
#include <cmath>
#include <optional>
#include <utility>

#include "cekf/landmark_slam.h"

namespace hymm::core {

LandmarkSlam::LandmarkSlam(const CekfSlamConfig& config, const VehicleConfig& vehicle,
                           CekfSlam::GlobalUpdates global_updates)
    : config_(config),
      vehicle_config_(vehicle),
      global_updates_(global_updates),
      perception_(config.perception),
      associator_(config.association,
                  config.update.atFirstEstimates() ? std::optional(config.update.relinearise_m)
                                                   : std::nullopt,
                  config.lasting_errors),
      scan_update_(config.update.atFirstEstimates()
                       ? ScanUpdate(config.update.max_iterations, config.large_correction_m)
                       : ScanUpdate(config.update.max_iterations)),
      place_finder_(config.place_finding, config.landmarks),
      life_cycle_(config),
      pins_(config.landmarks.pin_delay_s),
      area_(config.active_area),
      estimate_(newEstimate()) {}

LandmarkSlam::Estimate LandmarkSlam::newEstimate() const {
  VehicleState vehicle(vehicle_config_, config_.motion_input == "odom", config_.gps.enabled,
                       config_.update.atFirstEstimates(), config_.motion_noise);
  CompressedEkf filter(vehicle.initialState(), vehicle.initialCovariance(), global_updates_);
  Estimate estimate{vehicle, std::move(filter), std::nullopt};
  if (config_.gps.enabled) estimate.gps.emplace(config_.gps, vehicle.gpsDatumIndex());
  estimate.filter.holdGlobalUpdates(holds_global_updates_);
  return estimate;
}

void LandmarkSlam::reset() {
  estimate_.filter.finishGlobalUpdate();
  ++counts_.resets;
  ++version_;
  life_cycle_.clear();
  place_finder_ = PlaceFinder(config_.place_finding, config_.landmarks);
  pins_.clear();
  area_.reset();
  past_gaps_ += estimate_.vehicle.gaps();
  past_worker_s_ += estimate_.filter.workerCpu_s();
  estimate_ = newEstimate();
  settled_updates_ = 0;
  scan_clock_ = ScanClock();
  use_ = MapUse::kExtend;
  is_just_loaded_ = false;
}

// Where the vehicle was at a scan long before the first motion has nothing to do with where it is.
void LandmarkSlam::beginWithMotion(double time_s) {
  if (estimate_.vehicle.hasInput() || landmarkCount() > 0) return;
  if (!(time_s > scan_clock_.last_s() + estimate_.vehicle.holdLimit_s())) return;
  estimate_.filter.finishGlobalUpdate();
  life_cycle_.clear();
  estimate_ = newEstimate();
}

// One scan may come just before the first motion. Of more it is not known how the vehicle moved
// between them: as standing still, landmarks are smeared for good.
void LandmarkSlam::refuseWithoutMotion(Sight& sight) {
  if (!sight.set || estimate_.vehicle.hasInput()) return;
  ++counts_.scans_without_motion;
  if (!std::isfinite(scan_clock_.last_s())) return;
  sight.refuse("no motion input has come yet");
}

}  // namespace hymm::core
