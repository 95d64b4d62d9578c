#pragma once

#include <optional>

#include <nav_msgs/Odometry.h>

#include "common/pose2.h"
#include "ros/cause_log.h"
#include "vehicle/motion_input.h"

namespace hymm {

/// Odometry messages to twists. Sources that fill in poses only, and leave the twist zero, would
/// make a vehicle that drives look as if it stood: until a twist has been told, the velocity
/// between two poses counts, from the earlier one's stamp on.
class OdometryReader {
 public:
  /// Nothing where there is no earlier pose yet, or none that could have been driven from. That
  /// poses are used is counted among `causes`.
  std::optional<core::TwistInput> read(const nav_msgs::Odometry& message, CauseLog& causes);

  /// Another recording begins.
  void reset();

 private:
  struct StampedPose {
    double time_s;
    core::Pose2 T_odom_base;
  };

  std::optional<core::TwistInput> readPose(const nav_msgs::Odometry& message, CauseLog& causes);

  bool has_twist_ = false;
  std::optional<StampedPose> last_;
};

}  // namespace hymm
