#include "nodes/cekf_slam_node.h"
#include "ros/cloud_conversions.h"
#include "ros/node_main.h"

int main(int argc, char** argv) {
  return hymm::runNode(argc, argv, "cekf_slam", [] {
    const ros::NodeHandle private_handle("~");
    hymm::core::ConfigReport report;
    hymm::core::CekfSlamConfig config;
    hymm::readParameters(private_handle, config, report);
    const hymm::core::VehicleDescription vehicle = hymm::readVehicle(private_handle, report);
    const hymm::core::PointCloudConfig point_clouds = hymm::readPointClouds(private_handle, report);
    hymm::tellOrThrow(report);
    const hymm::CekfSlamNode node(config, vehicle, point_clouds);
    ros::spin();
  });
}
