#include "nodes/map_storage.h"
#include "nodes/supervisor_node.h"
#include "ros/node_main.h"
#include "ros/parameters.h"

int main(int argc, char** argv) {
  return hymm::runNode(argc, argv, "supervisor", [] {
    const ros::NodeHandle private_handle("~");
    hymm::core::ConfigReport report;
    hymm::core::SupervisorConfig config;
    hymm::core::CekfSlamConfig filter;
    hymm::readParameters(private_handle, config, report);
    hymm::readParameters(ros::NodeHandle("cekf_slam"), filter, report);
    const hymm::core::VehicleDescription vehicle = hymm::readVehicle(private_handle, report);
    const ros::NodeHandle map_handle("saved_map");
    hymm::SavedMapConfig saved_map;
    hymm::readParameters(map_handle, saved_map, report);
    const auto start_pose = saved_map.startPose(map_handle.getNamespace(), report);
    hymm::tellOrThrow(report);
    const hymm::SupervisorNode node(config, filter, vehicle.config);
    const hymm::MapStorage storage(saved_map, start_pose);
    ros::spin();
  });
}
