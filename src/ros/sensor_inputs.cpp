#include "ros/sensor_inputs.h"

namespace hymm {

SensorInputs::SensorInputs(ros::NodeHandle handle, const std::string& motion_input,
                           const std::string& observation_input, bool with_gps, SensorQueue& queue,
                           CauseLog& causes)
    : handle_(std::move(handle)), queue_(queue), causes_(causes) {
  if (motion_input == "odom") {
    subscribe<nav_msgs::Odometry>("odom");
  } else {
    subscribe<DeadReckoning>("dead_reckoning");
  }
  if (observation_input == "detections") {
    subscribe<LandmarkObservations>("detections");
  } else if (observation_input == "points") {
    subscribe<sensor_msgs::PointCloud2>("points");
  } else {
    subscribe<sensor_msgs::LaserScan>("scan");
  }
  if (with_gps) subscribe<sensor_msgs::NavSatFix>("gps/fix");
}

template <class Message>
void SensorInputs::subscribe(const std::string& topic) {
  const std::string name = handle_.resolveName(topic);
  const boost::function<void(const boost::shared_ptr<const Message>&)> take_it =
      [this, name](const boost::shared_ptr<const Message>& message) { take(name, message); };
  constexpr std::uint32_t kUnbounded = 0;  // SensorQueue bounds, and counts what it drops
  subscribers_.push_back(traffic_.subscribe<Message>(handle_, topic, kUnbounded, take_it,
                                                     ros::TransportHints().tcpNoDelay()));
  traffic_.expect(name);
}

void SensorInputs::take(const std::string& topic, SensorMessage message) {
  if (!queue_.push(std::move(message))) {
    causes_.count("queue full", "Messages come faster than they can be processed; on " + topic +
                                    " one was dropped.");
  }
}

}  // namespace hymm
