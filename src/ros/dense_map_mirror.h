#pragma once

#include <mutex>
#include <optional>
#include <string>

#include <map_msgs/OccupancyGridUpdate.h>
#include <nav_msgs/OccupancyGrid.h>
#include <ros/node_handle.h>

#include "hybrid_map/occupancy_image.h"
#include "ros/cause_log.h"
#include "ros/traffic_meter.h"

namespace hymm {

/// Keeps a copy of the dense map as `map` and `map_updates` tell it. What cannot be used is
/// refused, and counted with its cause. Thread-safe.
class DenseMapMirror {
 public:
  /// `causes` outlives the object.
  DenseMapMirror(std::string map_frame, CauseLog& causes)
      : map_frame_(std::move(map_frame)), causes_(causes) {}

  /// What comes is counted in `traffic`, which outlives the object.
  void subscribe(ros::NodeHandle& handle, TrafficMeter& traffic);

  void takeMap(const nav_msgs::OccupancyGrid& message);
  /// One that comes before its map is passed over: the map that follows holds it.
  void takeUpdate(const map_msgs::OccupancyGridUpdate& message);

  /// The map as it is, where it changed since the last call; nothing else, or before the first.
  std::optional<core::OccupancyImage> takeChanged();
  bool hasMap();
  /// The next takeChanged() tells the map even if it has not changed.
  void tellAgain();

 private:
  std::string map_frame_;
  CauseLog& causes_;
  std::mutex mutex_;
  std::optional<core::OccupancyImage> image_;
  bool has_changed_ = false;
  ros::Subscriber maps_, updates_;
};

}  // namespace hymm
