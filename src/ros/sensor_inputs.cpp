#include "ros/sensor_inputs.h"

#include "ros/steady_time.h"

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
  meters_[name].last_s = meters_[name].told_s = steadyNow();
  const boost::function<void(const boost::shared_ptr<const Message>&)> take_it =
      [this, name](const boost::shared_ptr<const Message>& message) { take(name, message); };
  constexpr std::uint32_t kUnbounded = 0;  // SensorQueue bounds, and counts what it drops
  subscribers_.push_back(handle_.subscribe<Message>(topic, kUnbounded, take_it, ros::VoidConstPtr(),
                                                    ros::TransportHints().tcpNoDelay()));
}

void SensorInputs::take(const std::string& topic, SensorMessage message) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++meters_[topic].messages;
    meters_[topic].last_s = steadyNow();
  }
  if (!queue_.push(std::move(message))) {
    causes_.count("queue full", "Messages come faster than they can be processed; on " + topic +
                                    " one was dropped.");
  }
}

std::vector<SensorInputs::Traffic> SensorInputs::traffic() {
  const std::lock_guard<std::mutex> lock(mutex_);
  const double now_s = steadyNow();
  std::vector<Traffic> all;
  for (auto& [topic, meter] : meters_) {
    const auto arrived = static_cast<double>(meter.messages - meter.messages_told);
    const double rate_hz = now_s > meter.told_s ? arrived / (now_s - meter.told_s) : 0.0;
    all.push_back({topic, meter.messages, now_s - meter.last_s, rate_hz});
    meter.messages_told = meter.messages;
    meter.told_s = now_s;
  }
  return all;
}

}  // namespace hymm
