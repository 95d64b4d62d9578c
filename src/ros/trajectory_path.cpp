#include "ros/trajectory_path.h"

#include <cmath>

#include "ros/pose_conversions.h"

namespace hymm {

TrajectoryPath::TrajectoryPath(const std::string& frame_id, double spacing_m, std::size_t max_poses)
    : spacing_m_(spacing_m), max_poses_(max_poses) {
  path_.header.frame_id = frame_id;
}

void TrajectoryPath::add(const ros::Time& stamp, const core::Pose2& pose) {
  if (!path_.poses.empty()) {
    const auto& last = path_.poses.back().pose.position;
    if (std::hypot(pose.x_m - last.x, pose.y_m - last.y) < spacing_m_) return;
  }
  if (path_.poses.size() >= max_poses_) thin();
  geometry_msgs::PoseStamped message;
  message.header.stamp = path_.header.stamp = stamp;
  message.header.frame_id = path_.header.frame_id;
  message.pose = toPoseMessage(pose);
  path_.poses.push_back(message);
}

void TrajectoryPath::thin() {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < path_.poses.size(); i += 2) path_.poses[kept++] = path_.poses[i];
  path_.poses.resize(kept);
}

}  // namespace hymm
