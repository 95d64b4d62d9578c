#include "nodes/dead_reckoning_node.h"

#include "ros/odometry_conversions.h"
#include "ros/sensor_conversions.h"

namespace hymm {
namespace {

constexpr std::uint32_t kQueue = 10000;

}  // namespace

DeadReckoningNode::DeadReckoningNode(const core::DeadReckoningConfig& config,
                                     const core::VehicleConfig& vehicle)
    : config_(config),
      vehicle_(vehicle),
      dead_reckoning_(vehicle),
      jump_filter_(config.clock_jump_s, config.clock_jump_messages) {
  publisher_ = handle_.advertise<nav_msgs::Odometry>("odom", kQueue);
  subscriber_ = traffic_.subscribe(handle_, "dead_reckoning", kQueue, &DeadReckoningNode::take,
                                   this, ros::TransportHints().tcpNoDelay());
  traffic_.expect(subscriber_.getTopic());
  diagnostics_.setHardwareID("none");
  diagnostics_.add("dead reckoning", this, &DeadReckoningNode::diagnose);
  diagnostics_timer_ = handle_.createSteadyTimer(
      ros::WallDuration(1.0),
      [this](const ros::SteadyTimerEvent&) { diagnostics_.force_update(); });
}

void DeadReckoningNode::take(const DeadReckoning& message) {
  const std::size_t strays = jump_filter_.strays();
  const auto [ran_back, believed] = jump_filter_.push({message.header.stamp.toSec(), message});
  for (std::size_t i = strays; i < jump_filter_.strays(); ++i) {
    causes_.count("stray",
                  "A dead_reckoning message has a stamp far from those around it; it is "
                  "not used.");
  }
  if (ran_back) {
    ROS_WARN("The time stamps ran back: dead reckoning begins anew at the origin.");
    dead_reckoning_.reset();
    ++jumps_;
  }
  for (const Stamped& stamped : believed) process(stamped.message);
}

void DeadReckoningNode::process(const DeadReckoning& message) {
  if (dead_reckoning_.process(fromMessage(message))) {
    publish(message.header.stamp);
  } else {
    causes_.count("refused",
                  "A dead_reckoning message has values that are not finite, or is not later than "
                  "the one before it; it is refused.");
  }
}

void DeadReckoningNode::publish(const ros::Time& stamp) {
  nav_msgs::Odometry odometry = odometryMessage(dead_reckoning_, vehicle_);
  odometry.header.stamp = stamp;  // as it came: seconds in a double are coarser
  publisher_.publish(odometry);
  if (!config_.publish_tf) return;
  geometry_msgs::TransformStamped transform = odometryTransform(dead_reckoning_, vehicle_);
  transform.header.stamp = stamp;
  broadcaster_.sendTransform(transform);
}

void DeadReckoningNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  status.summary(DiagnosticStatus::OK, "Dead reckoning goes on");
  traffic_.addTo(status);
  status.add("clock resets", jumps_);
  for (const auto& [cause, count] : causes_.counts()) status.add(cause, count);
}

}  // namespace hymm
