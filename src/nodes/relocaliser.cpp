#include "nodes/relocaliser_node.h"
#include "ros/node_main.h"
#include "ros/parameters.h"

int main(int argc, char** argv) {
  return hymm::runNode(argc, argv, "relocaliser", [] {
    const ros::NodeHandle private_handle("~");
    hymm::core::ConfigReport report;
    hymm::core::RelocaliserConfig config;
    hymm::core::CekfSlamConfig filter;
    hymm::readParameters(private_handle, config, report);
    hymm::readParameters(ros::NodeHandle("cekf_slam"), filter, report);
    const hymm::core::VehicleDescription vehicle = hymm::readVehicle(private_handle, report);
    hymm::tellOrThrow(report);
    const hymm::RelocaliserNode node(config, filter, vehicle.config);
    ros::spin();
  });
}
