#pragma once

#include <string>

#include <nav_msgs/Path.h>

#include "common/pose2.h"

namespace hymm {

/// The way driven, thinned so that it stays small however long the drive is.
class TrajectoryPath {
 public:
  TrajectoryPath(const std::string& frame_id, double spacing_m, std::size_t max_poses);

  /// Adds a pose if it is at least the spacing from the last one.
  void add(const ros::Time& stamp, const core::Pose2& pose);
  void clear() { path_.poses.clear(); }

  const nav_msgs::Path& message() const { return path_; }

 private:
  void thin();

  double spacing_m_;
  std::size_t max_poses_;
  nav_msgs::Path path_;
};

}  // namespace hymm
