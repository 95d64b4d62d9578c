#include "tools/acfr_bag_writer.h"

#include <cmath>

#include <geometry_msgs/TransformStamped.h>
#include <hymm/DeadReckoning.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/NavSatFix.h>
#include <tf2_msgs/TFMessage.h>

#include "ros/odometry_conversions.h"
#include "ros/pose_conversions.h"
#include "ros/sensor_conversions.h"
#include "tools/latched_message.h"

namespace hymm {
namespace {

constexpr char kWriter[] = "acfr_to_bag";

// The recordings are planar; nothing is known about height.
constexpr double kHeightVariance_m2 = 1e4;

// Bag times this much behind the last are a tie that was pushed on, not a clock that ran back.
const ros::Duration kTie(1e-6);

geometry_msgs::TransformStamped mountingMessage(const core::SensorMounting& mounting,
                                                const std::string& base_frame,
                                                const std::string& sensor_frame,
                                                const ros::Time& stamp) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = base_frame;
  message.child_frame_id = sensor_frame;
  message.transform = toTransformMessage(mounting.T_base_sensor());
  return message;
}

}  // namespace

AcfrBagWriter::AcfrBagWriter(rosbag::Bag& bag, const core::VehicleConfig& vehicle,
                             const GpsAssumptions& gps)
    : bag_(bag),
      vehicle_(vehicle),
      gps_(gps),
      local_frame_(gps.latitude_deg, gps.longitude_deg, gps.altitude_m),
      dead_reckoning_(vehicle) {}

void AcfrBagWriter::writeMountings(double time_s) {
  const ros::Time stamp(time_s);
  tf2_msgs::TFMessage mountings;
  mountings.transforms = {
      mountingMessage(vehicle_.laser, vehicle_.base_frame, vehicle_.laser_frame, stamp),
      mountingMessage(vehicle_.gps_antenna, vehicle_.base_frame, vehicle_.gps_frame, stamp)};
  writeLatched(bag_, "/tf_static", stamp, mountings, kWriter);
}

void AcfrBagWriter::writeGpsOrigin(double time_s) {
  sensor_msgs::NavSatFix origin;
  origin.header.stamp = ros::Time(time_s);
  origin.header.frame_id = vehicle_.gps_frame;
  origin.status.status = sensor_msgs::NavSatStatus::STATUS_NO_FIX;  // agreed upon, not measured
  origin.latitude = gps_.latitude_deg;
  origin.longitude = gps_.longitude_deg;
  origin.altitude = gps_.altitude_m;
  writeLatched(bag_, "/gps/origin", origin.header.stamp, origin, kWriter);
}

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
  if (!dead_reckoning_.process(input)) return;
  bag_.write("/odom", time, odometryMessage(dead_reckoning_, vehicle_));
  tf2_msgs::TFMessage transforms;
  transforms.transforms = {odometryTransform(dead_reckoning_, vehicle_)};
  bag_.write("/tf", time, transforms);
}

void AcfrBagWriter::write(const core::LocalFix& fix) {
  sensor_msgs::NavSatFix message;
  message.header.stamp = ros::Time(fix.time_s);
  message.header.frame_id = vehicle_.gps_frame;
  message.status.service = sensor_msgs::NavSatStatus::SERVICE_GPS;
  if (std::isfinite(fix.east_m) && std::isfinite(fix.north_m)) {
    message.status.status = sensor_msgs::NavSatStatus::STATUS_FIX;
    local_frame_.Reverse(fix.east_m, fix.north_m, 0.0, message.latitude, message.longitude,
                         message.altitude);
  } else {
    message.status.status = sensor_msgs::NavSatStatus::STATUS_NO_FIX;
    message.latitude = message.longitude = message.altitude = std::nan("");
  }
  const double variance = gps_.deviation_m * gps_.deviation_m;
  message.position_covariance[0] = message.position_covariance[4] = variance;
  message.position_covariance[8] = kHeightVariance_m2;
  message.position_covariance_type = sensor_msgs::NavSatFix::COVARIANCE_TYPE_APPROXIMATED;
  bag_.write("/gps/fix", nextBagTime(message.header.stamp), message);
}

}  // namespace hymm
