#pragma once

#include <optional>
#include <string>

#include <hymm/LoadMap.h>
#include <hymm/LoadState.h>
#include <hymm/SaveMap.h>
#include <hymm/SaveState.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <ros/spinner.h>

#include "nodes/saved_map_config.h"

namespace hymm {

/// The services `save_map` and `load_map` of the node `supervisor`: has the owners of the map,
/// cekf_slam and hymm_grid, write or read their parts, such that all are of one version of the
/// landmarks, and completes the folder. Works on a thread of its own.
class MapStorage {
 public:
  /// Offers the services. If `begin_with` names a folder, that is loaded as soon as the owners are
  /// there, with the vehicle at `start_pose` if that is told; if it cannot be, the node ends.
  MapStorage(const SavedMapConfig& begin_with, const std::optional<core::Pose2>& start_pose);
  ~MapStorage() { spinner_.stop(); }
  MapStorage(const MapStorage&) = delete;
  MapStorage& operator=(const MapStorage&) = delete;

 private:
  bool save(SaveMap::Request& request, SaveMap::Response& response);
  void collect(const std::string& folder, SaveMap::Response& response);
  bool load(LoadMap::Request& request, LoadMap::Response& response);
  void distribute(LoadMap::Request request, LoadMap::Response& response);
  void loadAtStart();

  SavedMapConfig begin_with_;
  std::optional<core::Pose2> start_pose_;
  ros::NodeHandle handle_;
  ros::CallbackQueue calls_;
  ros::ServiceServer save_service_, load_service_;
  ros::SteadyTimer start_timer_;
  double give_up_s_ = 0.0;  ///< by the wall, waiting for the owners at the start
  ros::AsyncSpinner spinner_{1, &calls_};
};

}  // namespace hymm
