#include "nodes/door_planner_node.h"
#include "ros/node_main.h"
#include "ros/parameters.h"

int main(int argc, char** argv) {
  return hymm::runNode(argc, argv, "door_planner", [] {
    const ros::NodeHandle private_handle("~");
    hymm::core::ConfigReport report;
    hymm::core::DoorPlannerConfig config;
    hymm::readParameters(private_handle, config, report);
    const hymm::core::VehicleDescription vehicle = hymm::readVehicle(private_handle, report);
    hymm::tellOrThrow(report);
    const hymm::DoorPlannerNode node(config, vehicle.config);
    ros::spin();
  });
}
