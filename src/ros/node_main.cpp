#include "ros/node_main.h"

#include <atomic>

#include "common/error.h"

namespace hymm {
namespace {

std::atomic<bool> has_failed{false};

}  // namespace

int runNode(int argc, char** argv, const char* name, const std::function<void()>& body) {
  try {
    ros::init(argc, argv, name);
    // Else the end of the body's last node handle would end the log, before its error is told.
    ros::start();
    body();
    ros::shutdown();
    return has_failed ? 1 : 0;
  } catch (const core::ConfigError& error) {
    for (const std::string& problem : error.problems()) ROS_FATAL_STREAM(problem);
    ROS_FATAL_STREAM(name << " does not start: " << error.problems().size()
                          << " parameter(s) cannot be used, see above.");
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(name << " ends: " << error.what());
  }
  // Left to the end of the process, ROS now and then destroys a mutex that a thread of its still
  // holds, and aborts.
  if (ros::isStarted()) ros::shutdown();
  return 1;
}

void endAfterFailure(const std::string& problem) {
  ROS_FATAL_STREAM(problem);
  has_failed = true;
  ros::requestShutdown();
}

void tellOrThrow(const core::ConfigReport& report) {
  for (const std::string& warning : report.warnings) ROS_WARN_STREAM(warning);
  report.throwIfUnusable();
}

}  // namespace hymm
