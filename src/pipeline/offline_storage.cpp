/// How an offline run begins with a saved map, and saves the one that it ends with.
#include <filesystem>

#include "common/error.h"
#include "pipeline/offline_run.h"
#include "storage/map_folder.h"

namespace hymm::core {
namespace {

// Of a pose that a user types in, about as RViz's initialpose has it.
constexpr double kPositionVariance_m2 = 0.25;
constexpr double kHeadingVariance_rad2 = 0.01;

SuiteStage::NamedPart readPart(const MapFolder& folder, const SavedPart& part) {
  return {(folder.path() / part.file).string(), folder.read(part)};
}

void addDifferences(const SavedSettings& saved, const SavedSettings& present,
                    std::vector<std::string>& notes) {
  for (const std::string& difference : differencesOf(saved, present)) {
    notes.push_back("Since the map was saved, a parameter has changed: " + difference + ".");
  }
}

}  // namespace

std::vector<std::string> OfflineRun::loadMap(const std::string& path, MapUse use,
                                             const std::optional<Pose2>& pose) {
  const MapFolder folder(path);
  const MapManifest manifest = folder.manifest();
  const SavedPart* landmarks = manifest.find(MapPart::kLandmarks);
  if (landmarks == nullptr) throw InputError(path + " holds no landmarks.");
  std::vector<std::string> notes;
  const SuiteStage::NamedPart part = readPart(folder, *landmarks);
  addDifferences(part.part.settings, settingsOf(config_.cekf_slam), notes);
  filter_.loadState(part.part.state, part.name, use);
  for (const auto& stage : stages_) {
    if (stage->partName().empty()) continue;
    const SavedPart* own = manifest.find(stage->partName());
    if (own == nullptr) {
      notes.push_back("The saved map has no part '" + stage->partName() + "'; it begins empty.");
      continue;
    }
    const SuiteStage::NamedPart read = readPart(folder, *own);
    addDifferences(read.part.settings, stage->settings(), notes);
    stage->load(read, filter_.mapVersion(), use);
  }
  if (pose) {
    filter_.placeVehicle(
        *pose, Eigen::Vector3d(kPositionVariance_m2, kPositionVariance_m2, kHeadingVariance_rad2)
                   .asDiagonal());
  }
  return notes;
}

void OfflineRun::saveMap(const std::string& path) {
  const MapFolder folder(path);
  folder.prepare();
  MapManifest manifest;
  manifest.landmark_version = filter_.mapVersion();
  manifest.notes["landmarks"] = std::to_string(filter_.landmarkCount());
  manifest.parts.push_back(
      folder.write(MapPart::kLandmarks, {settingsOf(config_.cekf_slam), filter_.saveState()}));
  for (const auto& stage : stages_) {
    const auto part = stage->savedPart();
    if (part) manifest.parts.push_back(folder.write(part->name, part->part));
  }
  folder.complete(manifest);
}

}  // namespace hymm::core
