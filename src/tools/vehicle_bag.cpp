#include "tools/vehicle_bag.h"

#include <cmath>
#include <utility>

#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <tf2_msgs/TFMessage.h>

#include "ros/odometry_conversions.h"
#include "ros/pose_conversions.h"
#include "tools/latched_message.h"

namespace hymm {
namespace {

constexpr double kHeightVariance_m2 = 1e4;

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

VehicleBag::VehicleBag(rosbag::Bag& bag, const core::VehicleConfig& vehicle,
                       const GeographicLib::LocalCartesian& gps_frame, std::string writer)
    : bag_(bag),
      vehicle_(vehicle),
      gps_frame_(gps_frame),
      writer_(std::move(writer)),
      dead_reckoning_(vehicle) {}

void VehicleBag::writeMountings(double time_s) {
  const ros::Time stamp(time_s);
  tf2_msgs::TFMessage mountings;
  mountings.transforms = {
      mountingMessage(vehicle_.laser, vehicle_.base_frame, vehicle_.laser_frame, stamp),
      mountingMessage(vehicle_.gps_antenna, vehicle_.base_frame, vehicle_.gps_frame, stamp)};
  writeLatched(bag_, "/tf_static", stamp, mountings, writer_);
}

void VehicleBag::writeGpsOrigin(double time_s) {
  sensor_msgs::NavSatFix origin;
  origin.header.stamp = ros::Time(time_s);
  origin.header.frame_id = vehicle_.gps_frame;
  origin.status.status = sensor_msgs::NavSatStatus::STATUS_NO_FIX;
  origin.latitude = gps_frame_.LatitudeOrigin();
  origin.longitude = gps_frame_.LongitudeOrigin();
  origin.altitude = gps_frame_.HeightOrigin();
  writeLatched(bag_, "/gps/origin", origin.header.stamp, origin, writer_);
}

void VehicleBag::writeOdometry(const core::MotionInput& input, const ros::Time& time) {
  if (!dead_reckoning_.process(input)) return;
  bag_.write("/odom", time, odometryMessage(dead_reckoning_, vehicle_));
  tf2_msgs::TFMessage transforms;
  transforms.transforms = {odometryTransform(dead_reckoning_, vehicle_)};
  bag_.write("/tf", time, transforms);
}

sensor_msgs::NavSatFix VehicleBag::fixAt(const ros::Time& stamp, double east_m,
                                         double north_m) const {
  sensor_msgs::NavSatFix message;
  message.header.stamp = stamp;
  message.header.frame_id = vehicle_.gps_frame;
  message.status.service = sensor_msgs::NavSatStatus::SERVICE_GPS;
  if (std::isfinite(east_m) && std::isfinite(north_m)) {
    message.status.status = sensor_msgs::NavSatStatus::STATUS_FIX;
    gps_frame_.Reverse(east_m, north_m, 0.0, message.latitude, message.longitude, message.altitude);
  } else {
    message.status.status = sensor_msgs::NavSatStatus::STATUS_NO_FIX;
    message.latitude = message.longitude = message.altitude = std::nan("");
  }
  message.position_covariance[8] = kHeightVariance_m2;
  return message;
}

}  // namespace hymm
