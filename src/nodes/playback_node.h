#pragma once

#include <set>
#include <string>
#include <vector>

#include <hymm/FilterHealth.h>
#include <hymm/GridStatus.h>
#include <ros/ros.h>
#include <rosgraph_msgs/Clock.h>

#include "common/config.h"

namespace hymm {

/// Parameters of the node `playback`.
struct PlaybackConfig {
  std::string bag;                ///< that the player plays; empty: not told
  std::string player = "player";  ///< node name of `rosbag play --pause --clock`
  std::string listeners;          ///< nodes that must be subscribed before it begins, by spaces
  double start_timeout_s = 60.0;  ///< longest wait for the nodes to be there

  void describe(core::ConfigSchema& schema);
};

/// The node `playback`: lets a paused `rosbag play` begin when every node is ready to listen, and
/// ends when the recording has ended and the filter has processed what it got.
class PlaybackNode {
 public:
  explicit PlaybackNode(const PlaybackConfig& config);

  /// Throws core::InputError if the bag cannot be played, and std::runtime_error, naming the nodes
  /// that are missing, if the start does not come about.
  void run();

 private:
  std::string missing() const;
  void waitForAll();
  void startPlayer();
  void waitForEnd();

  PlaybackConfig config_;
  std::vector<std::string> listeners_;
  double clock_wall_s_ = 0.0;   ///< when /clock last came
  double result_wall_s_ = 0.0;  ///< when the filter, or what follows it, last answered
  ros::NodeHandle handle_;
  ros::Subscriber clock_, health_, grid_;
};

}  // namespace hymm
