#include "perception/perception_config.h"

namespace hymm::core {

void PerceptionConfig::describe(ConfigSchema&) {}

}  // namespace hymm::core
