#pragma once

#include <cstdint>

#include <hymm/DeadReckoning.h>
#include <hymm/LandmarkObservations.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/LaserScan.h>

#include "perception/laser_scan.h"
#include "perception/observation.h"
#include "vehicle/motion_input.h"

/// Sensor messages to the core's types and back. Values are carried over as they are; whoever
/// receives them checks them.
namespace hymm {

/// The type of a message's TYPE_* constant; unknown for any other value.
core::LandmarkType landmarkType(std::uint8_t value);

/// Without intensities if they are not as many as ranges.
core::LaserScan fromMessage(const sensor_msgs::LaserScan& message);
sensor_msgs::LaserScan toMessage(const core::LaserScan& scan, const std::string& frame_id);

core::AckermannInput fromMessage(const DeadReckoning& message);
DeadReckoning toMessage(const core::AckermannInput& input, const std::string& frame_id);

/// The twist of the odometry; its pose is not used.
core::TwistInput fromMessage(const nav_msgs::Odometry& message);
/// What a sensor upside down measured, as an upright one with the same x axis would tell it.
void turnUpright(core::LaserScan& scan);
void turnUpright(core::ObservationSet& set);

/// Observations without the place of the sensor, which tf knows.
core::ObservationSet fromMessage(const LandmarkObservations& message);
LandmarkObservations toMessage(const core::ObservationSet& set, const std::string& frame_id);

}  // namespace hymm
