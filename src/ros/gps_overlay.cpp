#include "ros/gps_overlay.h"

#include <algorithm>
#include <utility>

#include "ros/time_conversions.h"

namespace hymm {
namespace {

// Two fixes determine a rigid motion and fit it exactly, wherever they lie.
constexpr std::size_t kFewestFixes = 3;
constexpr std::size_t kMostFixes = 20000;  // as many as the supervisor keeps poses
constexpr double kPosesKept_s = 5.0;       // a fix may come that much later than the pose after it
constexpr std::size_t kMostWaiting = 1000;
// Fixes come in order up to this. Beyond the stamp of one that comes later, others were stray.
constexpr double kOutOfOrder_s = 1.0;
constexpr float kPointSize_m = 0.7F;
constexpr double kHeight_m = 0.15;  // above the trajectory, seen from above

}  // namespace

GpsOverlay::GpsOverlay(const Eigen::Vector2d& antenna, std::string map_frame)
    : antenna_(antenna), map_frame_(std::move(map_frame)), converter_(antenna) {}

void GpsOverlay::addPose(double time_s, const core::Pose2& T_map_base) {
  poses_.push_back({time_s, T_map_base});
  while (time_s - poses_.front().time_s > kPosesKept_s) poses_.pop_front();
  compareWaiting();
}

void GpsOverlay::addFix(const sensor_msgs::NavSatFix& message) {
  const GpsConverter::Answer answer = converter_.convert(message);
  if (!answer.fix) return;
  const auto is_later = [](double time_s, const core::GpsFix& fix) { return time_s < fix.time_s; };
  const double time_s = answer.fix->time_s;
  waiting_.erase(
      std::upper_bound(waiting_.begin(), waiting_.end(), time_s + kOutOfOrder_s, is_later),
      waiting_.end());
  waiting_.insert(std::upper_bound(waiting_.begin(), waiting_.end(), time_s, is_later),
                  *answer.fix);
  if (waiting_.size() > kMostWaiting) waiting_.pop_back();
  compareWaiting();
}

void GpsOverlay::compareWaiting() {
  while (!waiting_.empty() && !poses_.empty() && waiting_.front().time_s <= poses_.back().time_s) {
    const core::GpsFix fix = waiting_.front();
    waiting_.pop_front();
    if (!gate_.keep(fix.time_s, fix.position)) continue;
    const std::optional<core::Pose2> T_map_base = core::poseAt(poses_, fix.time_s);
    if (!T_map_base) continue;
    alignment_.add(fix.position, *T_map_base * antenna_);
    fixes_.push_back(fix.position);
    if (fixes_.size() > kMostFixes) fixes_.pop_front();
    time_s_ = fix.time_s;
  }
}

std::size_t GpsOverlay::count() const { return alignment_.count(); }

visualization_msgs::Marker GpsOverlay::marker() const {
  visualization_msgs::Marker marker;
  marker.header.stamp = toRosTime(time_s_);
  marker.header.frame_id = map_frame_;
  marker.ns = "gps";
  marker.type = visualization_msgs::Marker::SPHERE_LIST;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = marker.scale.y = marker.scale.z = kPointSize_m;
  marker.color.r = 0.25F;
  marker.color.g = 0.85F;
  marker.color.b = 0.95F;
  marker.color.a = 1.0F;
  if (count() < kFewestFixes) {
    marker.action = visualization_msgs::Marker::DELETE;
    return marker;
  }
  const core::Pose2 T_map_gps = alignment_.T_to_from();
  for (const Eigen::Vector2d& p_gps : fixes_) {
    const Eigen::Vector2d p_map = T_map_gps * p_gps;
    geometry_msgs::Point point;
    point.x = p_map.x();
    point.y = p_map.y();
    point.z = kHeight_m;
    marker.points.push_back(point);
  }
  return marker;
}

void GpsOverlay::clear() {
  converter_.reset();
  gate_ = {};
  poses_.clear();
  waiting_.clear();
  alignment_ = {};
  fixes_.clear();
}

}  // namespace hymm
