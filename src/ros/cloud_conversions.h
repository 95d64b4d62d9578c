#pragma once

#include <string>

#include <ros/node_handle.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>

#include "common/config.h"
#include "perception/point_scan.h"
#include "ros/sensor_mountings.h"

namespace hymm {

/// The scan that a cloud shows, or why there is none.
struct CloudScan {
  sensor_msgs::LaserScan::ConstPtr scan;  ///< with the cloud's header
  std::string cause;                      ///< to count by; also where a scan has a flaw
  std::string problem;                    ///< a sentence
};

/// Sorts the points of a cloud in a band of heights by direction (see core::scanOfPoints). The scan
/// is in upright axes at the sensor, which point where the sensor's x axis does: its place on the
/// vehicle is `mounting.T_base_sensor`. The cloud needs fields x, y and z of one FLOAT32 or
/// FLOAT64 each.
CloudScan scanOfCloud(const sensor_msgs::PointCloud2& cloud,
                      const SensorMountings::Answer& mounting,
                      const core::PointCloudConfig& config);

/// The parameters `point_clouds`, searched from the handle's namespace upwards; the defaults where
/// there are none.
core::PointCloudConfig readPointClouds(const ros::NodeHandle& handle, core::ConfigReport& report);

}  // namespace hymm
