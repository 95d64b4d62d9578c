#include "ros/sensor_mountings.h"

#include <utility>

#include <ros/console.h>
#include <tf2/exceptions.h>

#include "ros/pose_conversions.h"

namespace hymm {
namespace {

/// Cosine of the angle between the sensor's z axis and the vehicle's.
double uprightness(const geometry_msgs::Quaternion& q) {
  return 1.0 - 2.0 * (q.x * q.x + q.y * q.y);
}

/// tf2 knows no leading slash; messages of old recordings have one.
std::string withoutSlash(const std::string& frame) {
  return frame.empty() || frame.front() != '/' ? frame : frame.substr(1);
}

constexpr double kUpright = 0.985;  // 10 degrees: the scan's plane is taken to be the ground's

}  // namespace

SensorMountings::SensorMountings(const tf2::BufferCore& tf, std::string base_frame,
                                 std::optional<core::Pose2> fallback, double wait_s)
    : tf_(tf), base_frame_(std::move(base_frame)), fallback_(fallback), wait_s_(wait_s) {}

SensorMountings::Answer SensorMountings::find(const std::string& sensor_frame,
                                              double steady_now_s) {
  auto [place, is_new] = entries_.try_emplace(sensor_frame, Entry{steady_now_s, {}});
  Entry& entry = place->second;
  if (is_new || !entry.answer.T_base_sensor) {
    entry.answer = ask(sensor_frame, steady_now_s - entry.first_asked_s);
  }
  return entry.answer;
}

void SensorMountings::reset() { entries_.clear(); }

SensorMountings::Answer SensorMountings::ask(const std::string& sensor_frame,
                                             double waited_s) const {
  if (sensor_frame.empty()) return {std::nullopt, false, "the message names no frame"};
  try {
    const auto transform =
        tf_.lookupTransform(base_frame_, withoutSlash(sensor_frame), ros::Time(0)).transform;
    if (uprightness(transform.rotation) < kUpright) {
      return {
          std::nullopt, false,
          "the sensor of frame '" + sensor_frame +
              "' is tilted by over 10 degrees or upside down; its scan is not in the plane of '" +
              base_frame_ + "'"};
    }
    return {fromMessage(transform), false, ""};
  } catch (const tf2::TransformException&) {
    if (waited_s < wait_s_) return {std::nullopt, true, ""};
  }
  const std::string unknown =
      "tf does not know where frame '" + sensor_frame + "' stands on '" + base_frame_ + "'";
  if (!fallback_) {
    return {std::nullopt, false,
            unknown + "; publish that static transform, or describe the laser in the vehicle"};
  }
  ROS_WARN_STREAM(unknown << "; the vehicle's description is used: x " << fallback_->x_m << " m, y "
                          << fallback_->y_m << " m, yaw " << fallback_->yaw_rad << " rad.");
  return {fallback_, false, ""};
}

}  // namespace hymm
