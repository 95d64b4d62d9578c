#include "nodes/recorder_config.h"

namespace hymm {

void RecorderConfig::describe(core::ConfigSchema& schema) {
  schema.text("output", output, "folder to write into; made if it does not exist");
  schema.number("save_period_s", save_period_s, core::Range::between(0.05, 3600.0),
                "how often a complete folder is saved while the run goes on, by the wall");
}

}  // namespace hymm
