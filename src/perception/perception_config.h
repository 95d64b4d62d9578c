#pragma once

#include "common/config.h"

namespace hymm::core {

/// Parameters of landmark detection in laser scans.
struct PerceptionConfig {
  void describe(ConfigSchema& schema);
};

}  // namespace hymm::core
