#include "nodes/playback_config.h"

namespace hymm {

void PlaybackConfig::describe(core::ConfigSchema& schema) {
  schema.text("bag", bag, "bag that the player plays: looked into first, if it is told");
  schema.text("play_args", play_args,
              "arguments that the player has of the user, which say what part of the bag it plays");
  schema.text("player", player, "name of the node `rosbag play`, started with --pause --clock");
  schema.text("listeners", listeners,
              "nodes that must be subscribed before it begins, separated by spaces");
  schema.number("start_timeout_s", start_timeout_s, core::Range::positive(),
                "longest wait, by the wall, for the player and the nodes that listen");
}

}  // namespace hymm
