#pragma once

#include "common/pose2.h"
#include "perception/laser_scan.h"
#include "vehicle/sweep_motion.h"

namespace hymm::core {

/// A scan that knows where its sensor was at each beam (LaserScan::T_stamp_beam), the vehicle
/// moving like `motion` from its stamp on. The scan as it is if its beams count as measured at one
/// instant, or the vehicle stood still.
LaserScan sweptScan(LaserScan scan, const SweepMotion& motion, const Pose2& T_base_sensor);

}  // namespace hymm::core
