#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <sensor_msgs/PointCloud2.h>

#include "perception/point_scan.h"

namespace hymm {

/// When the points of a cloud were measured.
struct PointTimes {
  static constexpr double kFarthest_s = 0.5;  ///< from the stamp, that is believed

  std::vector<double> after_stamp_s;  ///< for each point, of which unseen ones count for nothing
  std::string problem;                ///< why there are none though there is a field of them
};

/// What the fields of usual drivers tell of it: `time` (velodyne_pointcloud: seconds after the
/// stamp, negative where that is of the last packet), `t` (ouster_ros: nanoseconds), `offset_time`
/// (Livox: nanoseconds) and `timestamp` (Hesai, RoboSense: the time itself in seconds; Livox in
/// nanoseconds). Integers are taken for nanoseconds after the stamp, floats for seconds, doubles
/// for whichever of the three is near the stamp. If one seen point's time makes no sense, none
/// does. `points`: as many as the cloud has, whose layout was checked.
PointTimes pointTimes(const sensor_msgs::PointCloud2& cloud,
                      const std::vector<Eigen::Vector3f>& points,
                      const core::PointCloudConfig& config);

}  // namespace hymm
