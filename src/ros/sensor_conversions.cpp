#include "ros/sensor_conversions.h"

#include "ros/time_conversions.h"

namespace hymm {
namespace {

core::Observation fromMessage(const LandmarkObservation& message) {
  core::Observation observation;
  observation.range_m = message.range;
  observation.bearing_rad = message.bearing;
  observation.covariance << message.covariance[0], message.covariance[1], message.covariance[2],
      message.covariance[3];
  observation.type = landmarkType(message.type);
  observation.diameter_m = message.diameter;
  observation.diameter_variance = message.diameter_variance;
  observation.identity = message.identity;
  return observation;
}

LandmarkObservation toMessage(const core::Observation& observation) {
  LandmarkObservation message;
  message.range = observation.range_m;
  message.bearing = observation.bearing_rad;
  message.covariance = {observation.covariance(0, 0), observation.covariance(0, 1),
                        observation.covariance(1, 0), observation.covariance(1, 1)};
  message.type = static_cast<std::uint8_t>(observation.type);
  message.diameter = observation.diameter_m;
  message.diameter_variance = observation.diameter_variance;
  message.identity = observation.identity;
  return message;
}

}  // namespace

core::LandmarkType landmarkType(std::uint8_t value) {
  return value <= LandmarkObservation::TYPE_REFLECTOR ? static_cast<core::LandmarkType>(value)
                                                      : core::LandmarkType::kUnknown;
}

core::LaserScan fromMessage(const sensor_msgs::LaserScan& message) {
  core::LaserScan scan;
  scan.time_s = message.header.stamp.toSec();
  scan.time_increment_s = static_cast<double>(message.time_increment);
  scan.angle_min_rad = static_cast<double>(message.angle_min);
  scan.angle_increment_rad = static_cast<double>(message.angle_increment);
  scan.range_min_m = static_cast<double>(message.range_min);
  scan.range_max_m = static_cast<double>(message.range_max);
  scan.ranges_m = message.ranges;
  // Those of another length cannot be told of beams.
  if (message.intensities.size() == message.ranges.size()) scan.intensities = message.intensities;
  return scan;
}

sensor_msgs::LaserScan toMessage(const core::LaserScan& scan, const std::string& frame_id) {
  sensor_msgs::LaserScan message;
  message.header.stamp = toRosTime(scan.time_s);
  message.header.frame_id = frame_id;
  message.angle_min = static_cast<float>(scan.angle_min_rad);
  message.angle_increment = static_cast<float>(scan.angle_increment_rad);
  if (!scan.ranges_m.empty()) {
    message.angle_max = static_cast<float>(scan.bearing(scan.ranges_m.size() - 1));
  }
  message.time_increment = static_cast<float>(scan.time_increment_s);
  message.range_min = static_cast<float>(scan.range_min_m);
  message.range_max = static_cast<float>(scan.range_max_m);
  message.ranges = scan.ranges_m;
  message.intensities = scan.intensities;
  return message;
}

core::AckermannInput fromMessage(const DeadReckoning& message) {
  return {message.header.stamp.toSec(), message.speed, message.steering};
}

DeadReckoning toMessage(const core::AckermannInput& input, const std::string& frame_id) {
  DeadReckoning message;
  message.header.stamp = toRosTime(input.time_s);
  message.header.frame_id = frame_id;
  message.speed = input.speed_mps;
  message.steering = input.steering_rad;
  return message;
}

core::TwistInput fromMessage(const nav_msgs::Odometry& message) {
  return {message.header.stamp.toSec(), message.twist.twist.linear.x, message.twist.twist.linear.y,
          message.twist.twist.angular.z};
}

void turnUpright(core::LaserScan& scan) {
  scan.angle_min_rad = -scan.angle_min_rad;
  scan.angle_increment_rad = -scan.angle_increment_rad;
}

void turnUpright(core::ObservationSet& set) {
  for (core::Observation& observation : set.observations) {
    observation.bearing_rad = -observation.bearing_rad;
    observation.covariance(0, 1) = -observation.covariance(0, 1);
    observation.covariance(1, 0) = -observation.covariance(1, 0);
    observation.diameter_covariance[1] = -observation.diameter_covariance[1];
  }
}

core::ObservationSet fromMessage(const LandmarkObservations& message) {
  core::ObservationSet set;
  set.time_s = message.header.stamp.toSec();
  set.observations.reserve(message.observations.size());
  for (const auto& observation : message.observations) {
    set.observations.push_back(fromMessage(observation));
  }
  return set;
}

LandmarkObservations toMessage(const core::ObservationSet& set, const std::string& frame_id) {
  LandmarkObservations message;
  message.header.stamp = toRosTime(set.time_s);
  message.header.frame_id = frame_id;
  message.observations.reserve(set.observations.size());
  for (const core::Observation& observation : set.observations) {
    message.observations.push_back(toMessage(observation));
  }
  return message;
}

}  // namespace hymm
