#pragma once

#include <string>

#include "common/config.h"

namespace hymm {

/// Parameters of the node `playback`.
struct PlaybackConfig {
  std::string bag;                ///< that the player plays; empty: not told
  std::string play_args;          ///< of `rosbag play`: which part of the bag it plays
  std::string player = "player";  ///< node name of `rosbag play --pause --clock`
  std::string listeners;          ///< nodes that must be subscribed before it begins, by spaces
  double start_timeout_s = 60.0;  ///< longest wait for the nodes to be there

  void describe(core::ConfigSchema& schema);
};

}  // namespace hymm
