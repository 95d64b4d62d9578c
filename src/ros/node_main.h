#pragma once

#include <functional>
#include <string>

#include <ros/ros.h>

#include "common/config.h"

namespace hymm {

/// What main() of every node does: starts ROS, runs `body` until it returns, and tells a
/// configuration or input that cannot be used in the log, one line a problem. The exit code is 0
/// after an ordinary end, also by Ctrl-C, and 1 after a problem.
int runNode(int argc, char** argv, const char* name, const std::function<void()>& body);

/// For what cannot go on in another thread than that of `body`, or in a callback: tells why in the
/// log, and has the node end with 1.
void endAfterFailure(const std::string& problem);

/// Logs the warnings; throws ConfigError with all errors.
void tellOrThrow(const core::ConfigReport& report);

}  // namespace hymm
