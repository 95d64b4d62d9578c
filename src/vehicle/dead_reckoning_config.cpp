#include "vehicle/dead_reckoning_config.h"

namespace hymm::core {

void DeadReckoningConfig::describe(ConfigSchema& schema) {
  schema.flag("publish_tf", publish_tf,
              "broadcast odom -> base_link; false where the robot or the bag does");
  schema.number("clock_jump_s", clock_jump_s, Range::positive(),
                "messages older than the newest by more than this may be of a new recording");
  schema.integer("clock_jump_messages", clock_jump_messages, Range::between(1, 1000),
                 "how many such messages in a row make it a new recording");
}

}  // namespace hymm::core
