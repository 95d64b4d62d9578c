#pragma once

#include <string>

#include "common/config.h"

namespace hymm {

/// Parameters of the node `recorder`.
struct RecorderConfig {
  std::string output;           ///< folder
  double save_period_s = 10.0;  ///< by the wall

  void describe(core::ConfigSchema& schema);
};

}  // namespace hymm
