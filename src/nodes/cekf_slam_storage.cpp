#include <hymm/LoadState.h>
#include <hymm/SaveState.h>

#include "common/error.h"
#include "common/gaussian.h"
#include "nodes/cekf_slam_node.h"
#include "ros/map_part.h"
#include "ros/pose_conversions.h"

/// How the node `cekf_slam` saves its part of the map, and loads it.
namespace hymm {

void CekfSlamNode::advertiseStorage() {
  ros::NodeHandle handle("~");
  handle.setCallbackQueue(&patient_calls_);
  storage_services_ = {handle.advertiseService("save_state", &CekfSlamNode::saveState, this),
                       handle.advertiseService("load_state", &CekfSlamNode::loadState, this)};
}

bool CekfSlamNode::saveState(SaveState::Request& request, SaveState::Response& response) {
  core::MapPart part;
  part.settings = settings_;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    response.version = filter_.mapVersion();
    response.items = static_cast<std::uint32_t>(filter_.landmarkCount());
    if (request.step == SaveState::Request::WRITE) part.state = filter_.saveState();
  }
  if (request.step == SaveState::Request::WRITE) {
    writePart(request.folder, core::MapPart::kLandmarks, part, response);  // scans go on meanwhile
  } else {
    response.success = true;
  }
  return true;
}

bool CekfSlamNode::loadState(LoadState::Request& request, LoadState::Response& response) {
  try {
    const core::Pose2 pose = fromMessage(request.pose.pose);
    const Eigen::Matrix3d covariance = planarCovariance(request.pose);
    if (request.use_pose &&
        (!pose.vector().allFinite() || !core::isSemiDefiniteCovariance(covariance))) {
      throw core::InputError("The pose is not finite, or its covariance is none.");
    }
    const NamedPart read = readPart(request.folder, core::MapPart::kLandmarks);
    response.differences = core::differencesOf(read.part.settings, settings_);
    const std::lock_guard<std::mutex> lock(mutex_);
    if (request.check_only) {
      filter_.checkState(read.part.state, read.name);
    } else {
      install(read.part.state, read.name, request.localise_only);
      if (request.use_pose) filter_.placeVehicle(pose, covariance);
      forgetRecording();
      ROS_INFO_STREAM("Loaded " << filter_.landmarkCount() << " landmarks from " << read.name);
    }
    response.version = filter_.mapVersion();
    response.resets = filter_.counts().resets;
    response.items = static_cast<std::uint32_t>(filter_.landmarkCount());
    response.success = true;
  } catch (const std::exception& error) {
    response.message = error.what();
  }
  return true;
}

void CekfSlamNode::install(const std::string& state, const std::string& name, bool localise_only) {
  filter_.loadState(state, name, localise_only ? core::MapUse::kLocalise : core::MapUse::kExtend);
  queue_.clear();
  backlog_.clear();
  merger_.reset();
}

}  // namespace hymm
