#pragma once

#include <rosbag/bag.h>

#include "datasets/acfr_recording.h"
#include "tools/vehicle_bag.h"
#include "vehicle/vehicle_config.h"

namespace hymm {

/// What the recording itself does not tell about its GPS.
struct GpsAssumptions {
  /// Where the recording's local frame has its zero: Victoria Park, Sydney (WGS 84). The true place
  /// was not published; only relative positions matter.
  double latitude_deg = -33.8855;
  double longitude_deg = 151.1930;
  double altitude_m = 0.0;
  double deviation_m = 0.5;  ///< of a fix, east and north
};

/// Writes a recording of ACFR's utility car to a bag, as its ROS drivers would have published it:
/// /scan, /dead_reckoning, /odom and /tf from the wheel model, /gps/fix, and, latched at the start,
/// /tf_static and /gps/origin (the zero of the fixes' local frame).
///
/// The time of a message in the bag is its stamp, but events that share a stamp follow each other
/// by a nanosecond there, because readers sort by that time: so they come in the recording's order.
class AcfrBagWriter {
 public:
  AcfrBagWriter(rosbag::Bag& bag, const core::VehicleConfig& vehicle, const GpsAssumptions& gps);

  /// What holds for the whole recording, stamped `time_s`, before the first event.
  void writeMountings(double time_s) { vehicle_bag_.writeMountings(time_s); }
  void writeGpsOrigin(double time_s) { vehicle_bag_.writeGpsOrigin(time_s); }

  void write(const core::LaserScan& scan);
  /// Odometry and its transform are left out where the clock stands still or runs back.
  void write(const core::AckermannInput& input);
  void write(const core::LocalFix& fix);

 private:
  ros::Time nextBagTime(const ros::Time& stamp);

  rosbag::Bag& bag_;
  core::VehicleConfig vehicle_;
  GpsAssumptions gps_;
  VehicleBag vehicle_bag_;
  ros::Time last_bag_time_;
};

}  // namespace hymm
