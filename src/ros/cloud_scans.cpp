#include "ros/cloud_scans.h"

#include <utility>

namespace hymm {
namespace {

constexpr std::size_t kMostWaiting = 100;  // several seconds of a lidar; megabytes each

}  // namespace

CloudScans::CloudScans(SensorMountings mountings, const core::PointCloudConfig& config,
                       CauseLog& causes)
    : mountings_(std::move(mountings)), config_(config), causes_(causes) {}

std::vector<HeadedScan::ConstPtr> CloudScans::takeReady(double steady_now_s) {
  std::vector<HeadedScan::ConstPtr> scans;
  while (!waiting_.empty()) {
    const sensor_msgs::PointCloud2& cloud = *waiting_.front();
    const SensorMountings::Answer mounting =
        mountings_.findInSpace(cloud.header.frame_id, steady_now_s);
    if (mounting.waiting) break;
    CloudScan converted = scanOfCloud(cloud, mounting, config_);
    for (const auto& remark : converted.remarks) causes_.count(remark.cause, remark.problem);
    if (converted.scan) scans.push_back(std::move(converted.scan));
    waiting_.pop_front();
  }
  for (; waiting_.size() > kMostWaiting; waiting_.pop_front()) {
    causes_.count("point clouds dropped",
                  "A point cloud is dropped: too many wait for tf to tell where frame '" +
                      waiting_.front()->header.frame_id + "' stands.");
  }
  return scans;
}

}  // namespace hymm
