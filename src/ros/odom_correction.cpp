#include "ros/odom_correction.h"

#include <utility>

#include "ros/pose_conversions.h"

namespace hymm {

OdomCorrection::OdomCorrection(Lookup odometry, double wait_s)
    : odometry_(std::move(odometry)), wait_s_(wait_s) {}

void OdomCorrection::setPose(const ros::Time& stamp, const core::Pose2& T_map_base,
                             double steady_now_s) {
  if (waiting_.size() >= kMostWaiting) waiting_.pop_back();
  waiting_.push_back({stamp, T_map_base, steady_now_s});
  update(steady_now_s);
}

void OdomCorrection::update(double steady_now_s) {
  std::string told;
  for (std::size_t i = waiting_.size(); i > 0; --i) {
    const Waiting& pose = waiting_[i - 1];
    const TransformAnswer odometry = odometry_(pose.stamp);
    told = odometry.problem;
    if (!odometry.transform) continue;
    T_map_odom_ = pose.T_map_base * core::inverse(fromMessage(odometry.transform->transform));
    pose_stamp_ = pose.stamp;
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(i));
    problem_.reset();
    return;
  }
  if (!waiting_.empty() && steady_now_s - waiting_.front().since_s >= wait_s_) problem_ = told;
}

void OdomCorrection::reset() {
  waiting_.clear();
  T_map_odom_.reset();
  pose_stamp_ = ros::Time();
  problem_.reset();
}

}  // namespace hymm
