#pragma once

#include <map>
#include <mutex>
#include <string>
#include <vector>

#include <ros/node_handle.h>

#include "ros/cause_log.h"
#include "ros/sensor_queue.h"

namespace hymm {

/// Subscribes to the sensors of a vehicle and queues what comes.
class SensorInputs {
 public:
  /// What came on one topic.
  struct Traffic {
    std::string topic;
    std::size_t messages = 0;
    double newest_age_s = 0.0;  ///< wall time since the last one; since the start if there is none
    double rate_hz = 0.0;       ///< since the last call of traffic(), by the wall
  };

  /// `motion_input`: dead_reckoning or odom. `observation_input`: scan, points or
  /// detections.
  SensorInputs(ros::NodeHandle handle, const std::string& motion_input,
               const std::string& observation_input, bool with_gps, SensorQueue& queue,
               CauseLog& causes);

  /// One entry a topic.
  std::vector<Traffic> traffic();

 private:
  struct Meter {
    std::size_t messages = 0;
    std::size_t messages_told = 0;
    double last_s = 0.0;
    double told_s = 0.0;
  };

  template <class Message>
  void subscribe(const std::string& topic);
  void take(const std::string& topic, SensorMessage message);

  ros::NodeHandle handle_;
  SensorQueue& queue_;
  CauseLog& causes_;
  std::vector<ros::Subscriber> subscribers_;
  std::mutex mutex_;
  std::map<std::string, Meter> meters_;
};

}  // namespace hymm
