#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <string>

#include <ros/time.h>

#include "common/pose2.h"
#include "ros/transform_lookup.h"

namespace hymm {

/// Where odom is in map, so that the filter's pose and tf agree at the pose's stamp. Odometry may
/// come later than the pose, by longer than the time between poses: some wait meanwhile, and the
/// newest that tf has reached is used.
class OdomCorrection {
 public:
  /// Of base_link in odom at a stamp.
  using Lookup = std::function<TransformAnswer(const ros::Time&)>;

  /// As many poses wait; once there are more, the latest takes the place of the one before, so that
  /// the first is reached in the end.
  static constexpr std::size_t kMostWaiting = 32;

  /// A pose that waits for longer than `wait_s` is a problem.
  OdomCorrection(Lookup odometry, double wait_s);

  /// The filter's pose at `stamp`.
  void setPose(const ros::Time& stamp, const core::Pose2& T_map_base, double steady_now_s);

  /// Looks whether tf has reached poses that wait.
  void update(double steady_now_s);

  /// Another recording begins.
  void reset();

  const std::optional<core::Pose2>& T_map_odom() const { return T_map_odom_; }
  /// Of the pose behind T_map_odom(); zero without one.
  const ros::Time& pose_stamp() const { return pose_stamp_; }

  /// What tf says of a pose that has waited too long; nothing in good order.
  const std::optional<std::string>& problem() const { return problem_; }

 private:
  struct Waiting {
    ros::Time stamp;
    core::Pose2 T_map_base;
    double since_s;
  };

  Lookup odometry_;
  double wait_s_;
  std::deque<Waiting> waiting_;
  std::optional<core::Pose2> T_map_odom_;
  ros::Time pose_stamp_;
  std::optional<std::string> problem_;
};

}  // namespace hymm
