#include "nodes/hymm_grid_node.h"
#include "ros/node_main.h"
#include "ros/parameters.h"

int main(int argc, char** argv) {
  return hymm::runNode(argc, argv, "hymm_grid", [] {
    const ros::NodeHandle private_handle("~");
    hymm::core::ConfigReport report;
    hymm::core::HymmGridConfig config;
    hymm::readParameters(private_handle, config, report);
    const hymm::core::VehicleDescription vehicle = hymm::readVehicle(private_handle, report);
    const hymm::core::PointCloudConfig point_clouds = hymm::readPointClouds(private_handle, report);
    hymm::tellOrThrow(report);
    const hymm::HymmGridNode node(config, vehicle.config, point_clouds);
    ros::spin();
  });
}
