#include "vehicle/dead_reckoning_config.h"

namespace hymm::core {

void DeadReckoningConfig::describe(ConfigSchema& schema) {
  schema.flag("publish_tf", publish_tf,
              "broadcast odom -> base_link; false where the robot or the bag does");
  schema.number(
      "clock_jump_s", clock_jump_s, Range::positive(),
      "messages farther than this from the newest, before or after, are not believed until "
      "others confirm them; longer than their period");
  schema.integer("clock_jump_messages", clock_jump_messages, Range::between(1, 1000),
                 "how many such messages in a row mean a new recording, or a gap in this one");
}

}  // namespace hymm::core
