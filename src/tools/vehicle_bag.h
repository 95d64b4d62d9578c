#pragma once

#include <string>

#include <GeographicLib/LocalCartesian.hpp>
#include <rosbag/bag.h>
#include <sensor_msgs/NavSatFix.h>

#include "vehicle/dead_reckoning.h"
#include "vehicle/vehicle_config.h"

namespace hymm {

/// Writes to a bag what the drivers of any vehicle publish beside its sensors' messages.
class VehicleBag {
 public:
  /// `gps_frame`: the local frame of fixes. `writer`: the node that a playback says it comes from.
  VehicleBag(rosbag::Bag& bag, const core::VehicleConfig& vehicle,
             const GeographicLib::LocalCartesian& gps_frame, std::string writer);

  /// Latched /tf_static: where laser and GPS antenna stand.
  void writeMountings(double time_s);

  /// Latched /gps/origin: the zero of the fixes' local frame, agreed upon rather than measured.
  void writeGpsOrigin(double time_s);

  /// /odom and its /tf at `time` of the bag; left out where the input's clock stands still or runs
  /// back.
  void writeOdometry(const core::MotionInput& input, const ros::Time& time);

  /// A fix at a place in the local frame, without its covariance but for the height's: the vehicles
  /// are planar, so that nothing is known about it. Status NO_FIX if the place is not finite.
  sensor_msgs::NavSatFix fixAt(const ros::Time& stamp, double east_m, double north_m) const;

 private:
  rosbag::Bag& bag_;
  core::VehicleConfig vehicle_;
  GeographicLib::LocalCartesian gps_frame_;
  std::string writer_;
  core::DeadReckoning dead_reckoning_;
};

}  // namespace hymm
