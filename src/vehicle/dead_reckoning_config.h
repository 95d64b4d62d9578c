#pragma once

#include "common/config.h"

namespace hymm::core {

/// Parameters of the node `dead_reckoning`, as config/dead_reckoning.yaml documents them.
struct DeadReckoningConfig {
  bool publish_tf = true;
  double clock_jump_s = 1.0;
  int clock_jump_messages = 3;

  void describe(ConfigSchema& schema);
};

}  // namespace hymm::core
