#pragma once

#include <optional>

#include <nav_msgs/Odometry.h>

#include "ros/cause_log.h"
#include "ros/odometry_motion.h"
#include "ros/sensor_mountings.h"
#include "vehicle/motion_input.h"

namespace hymm {

/// Odometry messages to the motion of base_link. They tell of their child_frame_id, which may be a
/// camera's or an inertial unit's; where it stands on the vehicle tf knows.
class OdometryReader {
 public:
  struct Answer {
    std::optional<core::TwistInput> input;
    bool waiting = false;  ///< tf may yet tell where the frame stands: ask again with this message
  };

  /// What could not be used as it is, is counted among `causes`.
  Answer read(const nav_msgs::Odometry& message, SensorMountings& mountings, double steady_now_s,
              CauseLog& causes);

  /// Another recording begins.
  void reset() { motion_.reset(); }

 private:
  OdometryMotion motion_;
};

}  // namespace hymm
