#include "nodes/map_storage.h"

#include <ctime>
#include <vector>

#include "common/error.h"
#include "ros/node_main.h"
#include "ros/pose_conversions.h"
#include "ros/steady_time.h"
#include "storage/map_folder.h"

namespace hymm {
namespace {

constexpr double kStartPatience_s = 15.0;  // some run without hymm_grid
constexpr const char* kFilter = "cekf_slam";
constexpr const char* kGrid = "hymm_grid";

/// A call to an owner of a part, whose refusal becomes an OutputError or InputError with its
/// sentence.
template <class Service, class Error>
typename Service::Response ask(const std::string& node, const std::string& service,
                               const typename Service::Request& request) {
  Service call;
  call.request = request;
  if (!ros::service::call(node + "/" + service, call)) {
    throw Error("The node " + node + " does not answer; is it running?");
  }
  if (!call.response.success) throw Error(call.response.message);
  return call.response;
}

SaveState::Response askToSave(const std::string& node, std::uint8_t step,
                              const std::string& folder = {}, std::uint64_t version = 0) {
  SaveState::Request request;
  request.step = step;
  request.folder = folder;
  request.version = version;
  return ask<SaveState, core::OutputError>(node, "save_state", request);
}

bool isThere(const std::string& node) { return ros::service::exists(node + "/save_state", false); }

core::SavedPart partOf(const SaveState::Response& written) {
  return {written.name, written.file, written.bytes, written.unpacked_bytes, written.checksum};
}

std::string timeText() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

void requireAbsolute(const std::string& path) {
  if (!path.empty() && path.front() == '/') return;
  throw core::InputError("The path must be absolute; '" + path + "' is not.");
}

/// Lets the dense map go on, whatever became of the saving.
struct Release {
  bool due = false;
  ~Release() {
    if (!due) return;
    try {
      askToSave(kGrid, SaveState::Request::RELEASE);
    } catch (const std::exception&) {  // it goes on by itself
    }
  }
};

}  // namespace

MapStorage::MapStorage(const SavedMapConfig& begin_with,
                       const std::optional<core::Pose2>& start_pose)
    : begin_with_(begin_with), start_pose_(start_pose) {
  handle_.setCallbackQueue(&calls_);
  if (!begin_with_.folder.empty()) {
    give_up_s_ = steadyNow() + kStartPatience_s;
    start_timer_ = handle_.createSteadyTimer(
        ros::WallDuration(0.2), [this](const ros::SteadyTimerEvent&) { loadAtStart(); });
  }
  save_service_ = handle_.advertiseService("save_map", &MapStorage::save, this);
  load_service_ = handle_.advertiseService("load_map", &MapStorage::load, this);
  spinner_.start();
}

bool MapStorage::save(SaveMap::Request& request, SaveMap::Response& response) {
  try {
    requireAbsolute(request.path);
    core::MapFolder(request.path).prepare();
    collect(request.path, response);
    response.success = true;
    ROS_INFO_STREAM(response.message);
  } catch (const std::exception& error) {
    response.message = error.what();
    ROS_ERROR_STREAM("The map is not saved: " << error.what());
  }
  return true;
}

/// The dense map is held back first, so that it cannot run past the version that the landmarks are
/// then written at; it goes on to that, and writes.
void MapStorage::collect(const std::string& folder, SaveMap::Response& response) {
  Release release;
  const bool has_grid = isThere(kGrid);
  if (has_grid) {
    release.due = true;
    askToSave(kGrid, SaveState::Request::HOLD);
  }
  const SaveState::Response landmarks = askToSave(kFilter, SaveState::Request::WRITE, folder);
  core::MapManifest manifest;
  manifest.parts.push_back(partOf(landmarks));
  if (has_grid) {
    const SaveState::Response dense =
        askToSave(kGrid, SaveState::Request::WRITE, folder, landmarks.version);
    manifest.parts.push_back(partOf(dense));
    response.ltrs = dense.items;
  }
  manifest.landmark_version = landmarks.version;
  manifest.notes = {{"saved", timeText()},
                    {"landmarks", std::to_string(landmarks.items)},
                    {"ltrs", std::to_string(response.ltrs)}};
  core::MapFolder(folder).complete(manifest);
  response.landmark_version = landmarks.version;
  response.landmarks = landmarks.items;
  for (const core::SavedPart& part : manifest.parts) response.bytes += part.bytes;
  response.message = "Saved " + std::to_string(response.landmarks) + " landmarks and " +
                     std::to_string(response.ltrs) + " LTRs in " + folder + "." +
                     (has_grid ? "" : " hymm_grid does not run, so there is no dense map in it.");
}

bool MapStorage::load(LoadMap::Request& request, LoadMap::Response& response) {
  try {
    requireAbsolute(request.path);
    distribute(request, response);
    response.success = true;
    ROS_INFO_STREAM(response.message);
    for (const std::string& difference : response.differences) {
      ROS_WARN_STREAM("Since the map was saved, a parameter has changed: " << difference);
    }
  } catch (const std::exception& error) {
    response.message = error.what();
    ROS_ERROR_STREAM("The map is not loaded: " << error.what());
  }
  return true;
}

/// Nobody changes anything before both have found that they can.
void MapStorage::distribute(LoadMap::Request request, LoadMap::Response& response) {
  const core::MapManifest manifest = core::MapFolder(request.path).manifest();
  const bool has_grid = isThere(kGrid) && manifest.find(core::MapPart::kDenseMap) != nullptr;
  LoadState::Request order;
  order.folder = request.path;
  order.localise_only = request.localise_only;
  order.use_pose = request.use_pose;
  order.pose = request.pose;
  for (const bool check_only : {true, false}) {
    order.check_only = check_only;
    response.differences.clear();
    const auto landmarks = ask<LoadState, core::InputError>(kFilter, "load_state", order);
    response.landmarks = landmarks.items;
    response.landmark_version = order.version = landmarks.version;
    order.resets = landmarks.resets;
    for (const auto& text : landmarks.differences) response.differences.push_back(text);
    if (!has_grid) continue;
    const auto dense = ask<LoadState, core::InputError>(kGrid, "load_state", order);
    response.ltrs = dense.items;
    for (const auto& text : dense.differences) response.differences.push_back(text);
  }
  response.message = "Loaded " + std::to_string(response.landmarks) + " landmarks and " +
                     std::to_string(response.ltrs) + " LTRs from " + request.path +
                     (request.localise_only ? ", to localise only." : "; mapping goes on.");
}

void MapStorage::loadAtStart() {
  const bool all_there = isThere(kFilter) && isThere(kGrid);
  if (!all_there && steadyNow() < give_up_s_) return;
  start_timer_.stop();
  LoadMap::Request request;
  request.path = begin_with_.folder;
  request.localise_only = begin_with_.localise_only;
  if (start_pose_) {
    request.use_pose = true;
    const Eigen::Vector3d variances(0.25, 0.25, 0.01);  // as RViz's initialpose has them, about
    request.pose = toMessage(*start_pose_, variances.asDiagonal());
  }
  LoadMap::Response response;
  load(request, response);
  if (response.success) return;
  endAfterFailure("The map to begin with cannot be loaded, see above; the node ends.");
}

}  // namespace hymm
