#include "common/error.h"
#include "nodes/recorder_node.h"
#include "relocaliser/relocaliser_config.h"
#include "ros/node_main.h"
#include "ros/parameters.h"

int main(int argc, char** argv) {
  return hymm::runNode(argc, argv, "recorder", [] {
    const ros::NodeHandle private_handle("~");
    hymm::core::ConfigReport report;
    hymm::RecorderConfig config;
    hymm::readParameters(private_handle, config, report);
    if (config.output.empty()) {
      report.errors.push_back(private_handle.getNamespace() +
                              ": output must name a folder to write into.");
    }
    hymm::core::RelocaliserConfig relocaliser;
    hymm::readParameters(ros::NodeHandle("relocaliser"), relocaliser, report);
    const hymm::core::VehicleDescription vehicle = hymm::readVehicle(private_handle, report);
    hymm::tellOrThrow(report);
    hymm::RecorderNode node(config, vehicle.config, relocaliser.seed);
    ros::spin();
    node.finish();
  });
}
