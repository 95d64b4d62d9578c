#include <limits>

#include "cekf/landmark_slam.h"
#include "common/state_archive.h"

namespace hymm::core {
namespace {

constexpr const char* kStateKind = "hymm landmarks";
constexpr std::uint32_t kStateVersion = 6;

}  // namespace

template <class Archive>
void LandmarkSlam::describeState(Archive& archive) {
  double last_scan_s = lastScan_s();
  archive(version_, last_scan_s, settled_updates_, life_cycle_, pins_, area_);
  if (last_scan_s != lastScan_s()) scan_clock_ = ScanClock(last_scan_s);
  if (estimate_.gps) archive(*estimate_.gps);
}

std::string LandmarkSlam::saveState() {
  StateWriter archive;
  archive(std::string(kStateKind), kStateVersion);
  estimate_.vehicle.save(archive);
  archive(estimate_.gps.has_value());
  estimate_.filter.save(archive);
  describeState(archive);
  return archive.takeBytes();
}

void LandmarkSlam::checkState(std::string_view bytes, const std::string& name) const {
  LandmarkSlam trial(config_, vehicle_config_, CekfSlam::GlobalUpdates::kInline);
  trial.restoreState(bytes, name);
}

void LandmarkSlam::loadState(std::string_view bytes, const std::string& name, MapUse use) {
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

/// Into an engine that has just begun, or was reset.
void LandmarkSlam::restoreState(std::string_view bytes, const std::string& name) {
  StateReader archive(bytes, name);
  archive.require(archive.read<std::string>() == kStateKind, "it holds no landmarks");
  archive.requireSame(archive.read<std::uint32_t>() == kStateVersion,
                      "it is of another version of hymm; load it with that.");
  estimate_.vehicle.restore(archive);
  archive.require(archive.read<bool>() == estimate_.gps.has_value(), "its GPS states are missing");
  estimate_.filter.restore(archive);
  describeState(archive);
  archive.requireEnd();
  for (const RegisteredLandmark& landmark : life_cycle_.registry().slots()) {
    const DiameterState& diameter = landmark.diameter_state;
    const LastingErrorState& error = landmark.lasting_error;
    const bool is_there =
        landmark.id < 0 ||
        (estimate_.filter.holds(landmark.slot) && (!diameter.exists() || isThere(diameter)) &&
         (!error.exists() || estimate_.filter.holds(error.slot)));
    archive.require(is_there, "a landmark has no estimate");
  }
}

bool LandmarkSlam::isThere(const DiameterState& diameter) const {
  return estimate_.filter.holds(diameter.slot) && (diameter.half == 0 || diameter.half == 1);
}

/// The first event after a map was loaded: if it does not follow at once what the map saw last,
/// the clock begins anew, and what was seen earlier was seen before that.
void LandmarkSlam::goOnAfterLoad(double time_s) {
  if (!is_just_loaded_) return;
  is_just_loaded_ = false;
  const double saved_s = estimate_.vehicle.time_s();
  if (time_s >= saved_s && time_s <= saved_s + estimate_.vehicle.holdLimit_s()) return;
  estimate_.vehicle.restartClock();
  scan_clock_ = ScanClock();
  life_cycle_.beginSession(std::isfinite(saved_s) ? time_s - saved_s : 0.0);
  pins_.beginSession();
}

}  // namespace hymm::core
