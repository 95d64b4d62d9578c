#include "ros/dense_map_mirror.h"

#include "ros/grid_conversions.h"

namespace hymm {
void DenseMapMirror::subscribe(ros::NodeHandle& handle, TrafficMeter& traffic) {
  const auto hints = ros::TransportHints().tcpNoDelay();
  maps_ = traffic.subscribe(handle, "map", 2, &DenseMapMirror::takeMap, this, hints);
  updates_ =
      traffic.subscribe(handle, "map_updates", 1000, &DenseMapMirror::takeUpdate, this, hints);
}

void DenseMapMirror::takeMap(const nav_msgs::OccupancyGrid& message) {
  if (message.header.frame_id != map_frame_) {
    causes_.count("dense maps in another frame", "The dense map comes in the frame '" +
                                                     message.header.frame_id + "', not '" +
                                                     map_frame_ + "'; it is not used.");
    return;
  }
  const std::string problem = problemOf(message);
  if (!problem.empty()) {
    causes_.count("dense maps refused", "A dense map on `map` is not used: " + problem + ".");
    return;
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  image_ = fromMessage(message);
  has_changed_ = true;
}

void DenseMapMirror::takeUpdate(const map_msgs::OccupancyGridUpdate& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!image_) return;
  if (!applyUpdate(message, *image_)) {
    causes_.count("dense map updates that do not fit",
                  "An update on `map_updates` does not fit into the last `map`; it is not used.");
    return;
  }
  has_changed_ = true;
}

std::optional<core::OccupancyImage> DenseMapMirror::takeChanged() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!image_ || !has_changed_) return std::nullopt;
  has_changed_ = false;
  return image_;
}

bool DenseMapMirror::hasMap() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return image_.has_value();
}

void DenseMapMirror::tellAgain() {
  const std::lock_guard<std::mutex> lock(mutex_);
  has_changed_ = true;
}

}  // namespace hymm
