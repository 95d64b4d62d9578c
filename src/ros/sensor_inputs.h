#pragma once

#include <string>
#include <vector>

#include <ros/node_handle.h>

#include "ros/cause_log.h"
#include "ros/sensor_queue.h"
#include "ros/traffic_meter.h"

namespace hymm {

/// Subscribes to the sensors of a vehicle and queues what comes.
class SensorInputs {
 public:
  /// `motion_input`: dead_reckoning or odom. `observation_input`: scan, points or
  /// detections.
  SensorInputs(ros::NodeHandle handle, const std::string& motion_input,
               const std::string& observation_input, bool with_gps, SensorQueue& queue,
               CauseLog& causes);

  /// What came.
  TrafficMeter& traffic() { return traffic_; }

 private:
  template <class Message>
  void subscribe(const std::string& topic);
  void take(const std::string& topic, SensorMessage message);

  ros::NodeHandle handle_;
  SensorQueue& queue_;
  CauseLog& causes_;
  TrafficMeter traffic_;
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace hymm
