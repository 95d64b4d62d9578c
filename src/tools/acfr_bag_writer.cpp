#include "tools/acfr_bag_writer.h"

#include "ros/sensor_conversions.h"

namespace hymm {
namespace {

// Bag times this much behind the last are a tie that was pushed on, not a clock that ran back.
const ros::Duration kTie(1e-6);

}  // namespace

AcfrBagWriter::AcfrBagWriter(rosbag::Bag& bag, const core::VehicleConfig& vehicle,
                             const GpsAssumptions& gps)
    : bag_(bag),
      vehicle_(vehicle),
      gps_(gps),
      vehicle_bag_(bag, vehicle, {gps.latitude_deg, gps.longitude_deg, gps.altitude_m},
                   "acfr_to_bag") {}

ros::Time AcfrBagWriter::nextBagTime(const ros::Time& stamp) {
  const bool is_tie = stamp <= last_bag_time_ && last_bag_time_ - stamp < kTie;
  last_bag_time_ = is_tie ? last_bag_time_ + ros::Duration(0, 1) : stamp;
  return last_bag_time_;
}

void AcfrBagWriter::write(const core::LaserScan& scan) {
  bag_.write("/scan", nextBagTime(ros::Time(scan.time_s)), toMessage(scan, vehicle_.laser_frame));
}

void AcfrBagWriter::write(const core::AckermannInput& input) {
  const ros::Time time = nextBagTime(ros::Time(input.time_s));
  bag_.write("/dead_reckoning", time, toMessage(input, vehicle_.base_frame));
  vehicle_bag_.writeOdometry(input, time);
}

void AcfrBagWriter::write(const core::LocalFix& fix) {
  sensor_msgs::NavSatFix message =
      vehicle_bag_.fixAt(ros::Time(fix.time_s), fix.east_m, fix.north_m);
  const double variance = gps_.deviation_m * gps_.deviation_m;
  message.position_covariance[0] = message.position_covariance[4] = variance;
  message.position_covariance_type = sensor_msgs::NavSatFix::COVARIANCE_TYPE_APPROXIMATED;
  bag_.write("/gps/fix", nextBagTime(message.header.stamp), message);
}

}  // namespace hymm
