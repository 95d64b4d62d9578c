#pragma once

#include <string>
#include <vector>

#include <ros/node_handle.h>
#include <sensor_msgs/PointCloud2.h>

#include "common/config.h"
#include "perception/point_scan.h"
#include "ros/headed_scan.h"
#include "ros/sensor_mountings.h"

namespace hymm {

/// The scan that a cloud shows, or why there is none.
struct CloudScan {
  struct Remark {
    std::string cause;    ///< to count by
    std::string problem;  ///< a sentence
  };

  HeadedScan::ConstPtr scan;
  std::vector<Remark> remarks;  ///< why there is no scan, or which flaws it has
};

/// Sorts the points of a cloud in a band of heights by direction (see core::scanOfPoints). The scan
/// is in upright axes at the sensor, which point where the sensor's x axis does: its place on the
/// vehicle is `mounting.T_base_sensor`. The cloud needs fields x, y and z of one FLOAT32 or
/// FLOAT64 each; when its points were measured pointTimes() tells.
CloudScan scanOfCloud(const sensor_msgs::PointCloud2& cloud,
                      const SensorMountings::Answer& mounting,
                      const core::PointCloudConfig& config);

/// The parameters `point_clouds`, searched from the handle's namespace upwards; the defaults where
/// there are none.
core::PointCloudConfig readPointClouds(const ros::NodeHandle& handle, core::ConfigReport& report);

}  // namespace hymm
