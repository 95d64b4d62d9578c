#pragma once

#include <memory>

#include <ros/time.h>
#include <std_msgs/Header.h>

#include "perception/laser_scan.h"

namespace hymm {

/// A scan as the core knows it, with the header of the message that brought it.
struct HeadedScan {
  using ConstPtr = std::shared_ptr<const HeadedScan>;

  std_msgs::Header header;  ///< its stamp is that of the first beam, scan.time_s
  ros::Time told_stamp;     ///< as the message has it, which may be of the last beam
  core::LaserScan scan;
};

}  // namespace hymm
