#include "nodes/information_map_node.h"
#include "ros/node_main.h"
#include "ros/parameters.h"

int main(int argc, char** argv) {
  return hymm::runNode(argc, argv, "information_map", [] {
    const ros::NodeHandle private_handle("~");
    hymm::core::ConfigReport report;
    hymm::core::InformationMapConfig config;
    hymm::readParameters(private_handle, config, report);
    const hymm::core::VehicleDescription vehicle = hymm::readVehicle(private_handle, report);
    hymm::tellOrThrow(report);
    const hymm::InformationMapNode node(config, vehicle.config);
    ros::spin();
  });
}
