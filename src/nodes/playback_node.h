#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include <diagnostic_updater/diagnostic_updater.h>
#include <hymm/FilterHealth.h>
#include <hymm/GridStatus.h>
#include <ros/ros.h>
#include <rosgraph_msgs/Clock.h>

#include "nodes/playback_config.h"
#include "ros/player_arguments.h"
#include "ros/traffic_meter.h"

namespace hymm {

/// The node `playback`: lets a paused `rosbag play` begin when every node is connected to those
/// that it listens to, and ends when the recording has ended and the filter has processed what it
/// got.
class PlaybackNode {
 public:
  explicit PlaybackNode(const PlaybackConfig& config);

  /// Throws core::InputError if the bag cannot be played, and std::runtime_error, naming the nodes
  /// that are missing, if the start does not come about. A bag without what the nodes listen to, be
  /// it for other names of topics, is an InputError too.
  void run();

 private:
  std::string nodeName(const std::string& name) const;
  std::string missing() const;
  void lookIntoBag();
  void takeClock(const rosgraph_msgs::Clock& message);
  void waitForAll();
  void waitForLinks();
  void startPlayer();
  std::string silentSensors() const;
  void requireSensors() const;
  void waitForEnd();
  void requireEnd() const;
  void pause();
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  PlaybackConfig config_;
  std::vector<std::string> listeners_;
  std::optional<PlayedSpan> span_;  ///< of stamps that are to be played; not known where it loops
  double clock_wall_s_ = 0.0;       ///< when /clock last came
  std::optional<double> clock_s_;   ///< what it said
  double played_s_ = 0.0;           ///< by /clock
  double played_wall_s_ = 0.0;      ///< what that took, pauses left out
  double result_wall_s_ = 0.0;      ///< when the filter, or what follows it, last answered
  ros::NodeHandle handle_;
  ros::Subscriber clock_, health_, grid_;
  TrafficMeter traffic_;
  diagnostic_updater::Updater diagnostics_;
  std::string state_ = "Looks into the bag";
  double told_wall_s_ = 0.0;
};

}  // namespace hymm
