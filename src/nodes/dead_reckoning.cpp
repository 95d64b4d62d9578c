#include "nodes/dead_reckoning_node.h"
#include "ros/node_main.h"
#include "ros/parameters.h"

int main(int argc, char** argv) {
  return hymm::runNode(argc, argv, "dead_reckoning", [] {
    const ros::NodeHandle private_handle("~");
    hymm::core::ConfigReport report;
    hymm::core::DeadReckoningConfig config;
    hymm::readParameters(private_handle, config, report);
    const hymm::core::VehicleDescription vehicle = hymm::readVehicle(private_handle, report);
    hymm::tellOrThrow(report);
    const hymm::DeadReckoningNode node(config, vehicle.config);
    ros::spin();
  });
}
