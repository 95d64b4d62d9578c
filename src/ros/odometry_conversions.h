#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>

#include "vehicle/dead_reckoning.h"
#include "vehicle/vehicle_config.h"

/// Dead reckoning as a robot's driver publishes it.
namespace hymm {

/// Pose in the odom frame and twist in base_link, both with covariance, stamped with the last
/// input. What a planar vehicle cannot do (z, roll, pitch) has covariance 0.
nav_msgs::Odometry odometryMessage(const core::DeadReckoning& dead_reckoning,
                                   const core::VehicleConfig& vehicle);

/// odom -> base_link.
geometry_msgs::TransformStamped odometryTransform(const core::DeadReckoning& dead_reckoning,
                                                  const core::VehicleConfig& vehicle);

}  // namespace hymm
