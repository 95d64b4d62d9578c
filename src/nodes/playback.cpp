#include "nodes/playback_node.h"
#include "ros/node_main.h"
#include "ros/parameters.h"

int main(int argc, char** argv) {
  return hymm::runNode(argc, argv, "playback", [] {
    const ros::NodeHandle private_handle("~");
    hymm::core::ConfigReport report;
    hymm::PlaybackConfig config;
    hymm::readParameters(private_handle, config, report);
    hymm::tellOrThrow(report);
    hymm::PlaybackNode(config).run();
  });
}
