#pragma once

#include <deque>
#include <vector>

#include "ros/cause_log.h"
#include "ros/cloud_conversions.h"
#include "ros/sensor_mountings.h"

namespace hymm {

/// Turns point clouds into scans as they come, in their order. Until tf tells where the sensor
/// stands they wait, a few of them; what cannot be used is counted.
class CloudScans {
 public:
  CloudScans(SensorMountings mountings, const core::PointCloudConfig& config, CauseLog& causes);

  void add(const sensor_msgs::PointCloud2::ConstPtr& cloud) { waiting_.push_back(cloud); }

  /// Scans of the clouds whose sensor has a place now. `steady_now_s`: see SensorMountings.
  std::vector<HeadedScan::ConstPtr> takeReady(double steady_now_s);

 private:
  SensorMountings mountings_;
  core::PointCloudConfig config_;
  CauseLog& causes_;
  std::deque<sensor_msgs::PointCloud2::ConstPtr> waiting_;
};

}  // namespace hymm
