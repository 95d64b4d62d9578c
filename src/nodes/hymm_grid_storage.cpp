#include <chrono>
#include <thread>

#include <hymm/LoadState.h>
#include <hymm/SaveState.h>

#include "nodes/hymm_grid_node.h"
#include "ros/map_part.h"
#include "ros/steady_time.h"

/// How the node `hymm_grid` saves its part of the map, and loads it.
namespace hymm {
namespace {

constexpr double kHold_s = 10.0;
constexpr double kVersionPatience_s = 20.0;  // it may have to wait for a whole landmark map first
constexpr auto kNap = std::chrono::milliseconds(5);

}  // namespace

bool HymmGridNode::saveState(SaveState::Request& request, SaveState::Response& response) {
  if (request.step == SaveState::Request::WRITE) {
    writeState(request, response);
    return true;
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  held_until_s_ = request.step == SaveState::Request::HOLD ? steadyNow() + kHold_s : 0.0;
  held_version_ = mapper_.map().landmarkVersion();
  response.version = held_version_;
  response.success = true;
  return true;
}

void HymmGridNode::writeState(const SaveState::Request& request, SaveState::Response& response) {
  core::MapPart part;
  part.settings = core::settingsOf(config_);
  const double give_up_s = steadyNow() + kVersionPatience_s;
  bool is_there = false;
  while (!is_there && steadyNow() < give_up_s && ros::ok()) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      held_version_ = request.version;
      held_until_s_ = give_up_s;
      response.version = mapper_.map().landmarkVersion();
      is_there = request.version == 0 || response.version == request.version;
      if (is_there) {
        part.state = mapper_.saveState();
        response.items = static_cast<std::uint32_t>(mapper_.map().partition().mesh().aliveCount());
      }
      if (is_there || response.version > request.version) held_until_s_ = 0.0;
    }
    if (!is_there && response.version > request.version) break;
    if (!is_there) std::this_thread::sleep_for(kNap);
  }
  if (is_there) {
    writePart(request.folder, core::MapPart::kDenseMap, part, response);
  } else {
    response.message = "The dense map is at version " + std::to_string(response.version) +
                       " of the landmarks, not at " + std::to_string(request.version) +
                       ": messages got lost on their way. Try again.";
  }
}

/// While a map is being saved: whether the next scan belongs to it no more.
bool HymmGridNode::isHeld() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return steadyNow() < held_until_s_ && mapper_.map().landmarkVersion() >= held_version_;
}

bool HymmGridNode::loadState(LoadState::Request& request, LoadState::Response& response) {
  try {
    const NamedPart read = readPart(request.folder, core::MapPart::kDenseMap);
    response.differences = core::differencesOf(read.part.settings, core::settingsOf(config_));
    if (!request.check_only) {
      const std::lock_guard<std::mutex> lock(inputs_mutex_);
      pairing_.clear();
      samples_.clear();
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    if (request.check_only) {
      mapper_.checkState(read.part.state, read.name);
    } else {
      install(read.part.state, read.name, request);
    }
    response.items = static_cast<std::uint32_t>(mapper_.map().partition().mesh().aliveCount());
    response.version = mapper_.map().landmarkVersion();
    response.success = true;
  } catch (const std::exception& error) {
    response.message = error.what();
  }
  return true;
}

void HymmGridNode::install(const std::string& state, const std::string& name,
                           const LoadState::Request& request) {
  mapper_.loadState(state, name, request.version,
                    request.localise_only ? core::MapUse::kLocalise : core::MapUse::kExtend);
  sample_placer_.clear();
  last_scan_.reset();
  awaited_resets_ = request.resets;
  awaited_until_s_ = steadyNow() + kHold_s;
  output_.resetToLoaded();
  output_.publishLtrs(stamp_);
  ROS_INFO_STREAM("Loaded " << mapper_.map().partition().mesh().aliveCount() << " LTRs from "
                            << name);
}

/// Whether what belongs to a scan is of the map before the one that was loaded.
bool HymmGridNode::isOfMapBefore(const PairedScan& paired) {
  if (!awaited_resets_) return false;
  const bool has_come = paired.pose && paired.pose->resets == *awaited_resets_;
  if (has_come) filter_ = core::FilterLife();  // of the map that is here already
  if (has_come || steadyNow() > awaited_until_s_) awaited_resets_.reset();
  return !has_come && awaited_resets_.has_value();
}

}  // namespace hymm
