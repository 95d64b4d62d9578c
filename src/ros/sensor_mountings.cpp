#include "ros/sensor_mountings.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>
#include <vector>

#include "ros/pose_conversions.h"
#include "ros/transform_lookup.h"

namespace hymm {
namespace {

/// Cosine of the angle between the sensor's z axis and the vehicle's.
double uprightness(const geometry_msgs::Quaternion& q) {
  return 1.0 - 2.0 * (q.x * q.x + q.y * q.y);
}

/// Why `frame` cannot be found, where tf has others; empty where tf has none or has it.
std::string framesInstead(const tf2::BufferCore& tf, const std::string& frame) {
  std::vector<std::string> frames;
  tf._getFrameStrings(frames);
  if (frames.empty() || std::find(frames.begin(), frames.end(), frame) != frames.end()) return "";
  std::sort(frames.begin(), frames.end());
  std::string list;
  for (const std::string& other : frames) list += (list.empty() ? "'" : ", '") + other + "'";
  return " (tf has no frame '" + frame + "'; it has " + list +
         ". The vehicle's base_frame, odom_frame and map_frame say which are used)";
}

constexpr std::size_t kMostFrames = 64;  // names come in messages; memory does not grow with them
constexpr double kUpright = 0.985;       // 10 degrees: the scan's plane is taken to be the ground's

SensorMountings::Answer answerOf(const geometry_msgs::Transform& transform) {
  SensorMountings::Answer answer;
  answer.T_base_sensor = fromMessage(transform);
  answer.upside_down = uprightness(transform.rotation) < 0.0;
  const auto& q = transform.rotation;
  const auto& t = transform.translation;
  answer.T_base_frame.linear() = Eigen::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix();
  answer.T_base_frame.translation() << t.x, t.y, t.z;
  return answer;
}

}  // namespace

SensorMountings::SensorMountings(const tf2::BufferCore& tf, std::string base_frame,
                                 std::optional<core::Pose2> fallback, double wait_s)
    : tf_(tf), base_frame_(std::move(base_frame)), fallback_(fallback), wait_s_(wait_s) {}

SensorMountings::Answer SensorMountings::find(const std::string& sensor_frame,
                                              double steady_now_s) {
  return remembered(sensor_frame, false, steady_now_s);
}

SensorMountings::Answer SensorMountings::findInSpace(const std::string& sensor_frame,
                                                     double steady_now_s) {
  return remembered(sensor_frame, true, steady_now_s);
}

SensorMountings::Answer SensorMountings::remembered(const std::string& sensor_frame, bool in_space,
                                                    double steady_now_s) {
  if (entries_.size() >= kMostFrames && entries_.count({sensor_frame, in_space}) == 0) {
    Answer answer;
    answer.problem = "messages of " + std::to_string(kMostFrames) +
                     " other frames came before; give each sensor one frame, and keep it";
    return answer;
  }
  auto [place, is_new] = entries_.try_emplace({sensor_frame, in_space}, Entry{steady_now_s, {}});
  Entry& entry = place->second;
  if (is_new || !entry.answer.T_base_sensor) {
    entry.answer = ask(sensor_frame, in_space, steady_now_s - entry.first_asked_s);
  }
  return entry.answer;
}

void SensorMountings::reset() { entries_.clear(); }

SensorMountings::Answer SensorMountings::ask(const std::string& sensor_frame, bool in_space,
                                             double waited_s) const {
  Answer answer;
  if (sensor_frame.empty()) {
    answer.problem = "the message names no frame";
    return answer;
  }
  const TransformAnswer found =
      findTransform(tf_, base_frame_, withoutSlash(sensor_frame), ros::Time(0));
  if (found.transform) {
    const geometry_msgs::Transform& transform = found.transform->transform;
    if (in_space || std::abs(uprightness(transform.rotation)) >= kUpright)
      return answerOf(transform);
    answer.problem = "the sensor of frame '" + sensor_frame +
                     "' is tilted by over 10 degrees; its scan is not in the plane of '" +
                     base_frame_ + "'";
    return answer;
  }
  answer.waiting = waited_s < wait_s_;
  if (answer.waiting) return answer;
  answer.problem = "tf does not know where frame '" + sensor_frame + "' stands on '" + base_frame_ +
                   "'" + framesInstead(tf_, base_frame_);
  if (in_space) {
    answer.problem += "; publish that static transform";
  } else if (!fallback_) {
    answer.problem += "; publish that static transform, or describe the laser in the vehicle";
  } else {
    std::ostringstream assumed;
    assumed << answer.problem << "; the vehicle's description is used: x " << fallback_->x_m
            << " m, y " << fallback_->y_m << " m, yaw " << fallback_->yaw_rad << " rad";
    answer.assumed = assumed.str();
    answer.problem.clear();
    answer.T_base_sensor = fallback_;
  }
  return answer;
}

}  // namespace hymm
