#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <geometry_msgs/TransformStamped.h>
#include <rosbag/bag.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/point_cloud2_iterator.h>
#include <tf2_msgs/TFMessage.h>

#include "ros/sensor_conversions.h"
#include "support/analytic_laser.h"

namespace hymm::test {

/// A car drives 36 m straight ahead at 3 m/s between two rows of trunks: what its bag holds.
struct Drive {
  double begin_s = 100.0;         ///< stamp of the first motion input
  double recorded_later_s = 0.0;  ///< record time less stamp
  std::string scan_topic = "/scan";
  bool has_scans = true;
  bool has_dead_reckoning = true;
  bool has_odom = false;
  bool has_gps = true;
  bool has_tf = true;
  bool has_detections = false;
  bool has_points = false;      ///< clouds of a lidar in the laser's place: trunks, and ground
  double motion_ahead_s = 0.0;  ///< stamps of motion, by a clock of its own
  bool motion_has_stamps = true;
  double lost_motion_from_s = 0.0;  ///< since the begin; up to the next
  double lost_motion_to_s = 0.0;
  std::function<void(sensor_msgs::LaserScan&, int)> spoil;  ///< changes the scan of an index
};

inline constexpr int kDriveScans = 60;

namespace drive_detail {

constexpr double kSpeed_mps = 3.0;
constexpr int kInputs = 240;  // at 20 Hz
constexpr double kInput_s = 0.05;
constexpr int kInputsPerScan = 4;
constexpr double kLaserAhead_m = 2.0;

inline core::LaserScan scanAt(double x_m) {
  core::AnalyticLaser laser;
  for (int i = 0; i < 10; ++i) {
    const double ahead_m = 6.0 * i - x_m - kLaserAhead_m;
    laser.disc(ahead_m, 5.0 + 0.4 * (i % 3), 0.3).disc(ahead_m + 2.0, -6.0 - 0.3 * (i % 4), 0.4);
  }
  return laser.halfTurn();
}

inline core::ObservationSet detectionsAt(double x_m) {
  core::ObservationSet set;
  for (int i = 0; i < 10; ++i) {
    const Eigen::Vector2d p(6.0 * i - x_m - kLaserAhead_m, 5.0);
    if (p.x() < 0.0 || p.norm() > 30.0) continue;
    core::Observation observation;
    observation.range_m = p.norm();
    observation.bearing_rad = std::atan2(p.y(), p.x());
    observation.covariance = Eigen::Vector2d(0.01, 1e-4).asDiagonal();
    set.observations.push_back(observation);
  }
  return set;
}

/// What a lidar 1 m above base_link sees where the laser sees `scan`.
inline sensor_msgs::PointCloud2 cloudOf(const core::LaserScan& scan) {
  std::vector<Eigen::Vector3f> points;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double bearing = scan.bearing(i);
    const Eigen::Vector2f along(std::cos(bearing), std::sin(bearing));
    for (const float ground : {4.0F, 9.0F}) {
      if (scan.ranges_m[i] > ground)
        points.emplace_back(ground * along.x(), ground * along.y(), -1.0F);
    }
    if (!std::isfinite(scan.ranges_m[i])) continue;
    const Eigen::Vector2f end = scan.ranges_m[i] * along;
    for (const float height : {-0.4F, 0.0F, 0.5F}) points.emplace_back(end.x(), end.y(), height);
  }
  sensor_msgs::PointCloud2 cloud;
  sensor_msgs::PointCloud2Modifier modifier(cloud);
  modifier.setPointCloud2FieldsByString(1, "xyz");
  modifier.resize(points.size());
  sensor_msgs::PointCloud2Iterator<float> x(cloud, "x"), y(cloud, "y"), z(cloud, "z");
  for (const Eigen::Vector3f& point : points) {
    *x = point.x(), *y = point.y(), *z = point.z();
    ++x, ++y, ++z;
  }
  return cloud;
}

inline tf2_msgs::TFMessage laserTransform(const ros::Time& stamp) {
  tf2_msgs::TFMessage message;
  message.transforms.resize(1);
  message.transforms[0].header.stamp = stamp;
  message.transforms[0].header.frame_id = "base_link";
  message.transforms[0].child_frame_id = "laser";
  message.transforms[0].transform.translation.x = kLaserAhead_m;
  message.transforms[0].transform.translation.z = 1.0;
  message.transforms[0].transform.rotation.w = 1.0;
  return message;
}

inline sensor_msgs::NavSatFix fixAt(const ros::Time& stamp, double x_m) {
  sensor_msgs::NavSatFix message;
  message.header.stamp = stamp;
  message.header.frame_id = "gps";
  message.latitude = -33.0 + x_m / 110900.0;  // due north
  message.longitude = 151.0;
  message.position_covariance = {0.25, 0, 0, 0, 0.25, 0, 0, 0, 1.0};
  message.position_covariance_type = sensor_msgs::NavSatFix::COVARIANCE_TYPE_DIAGONAL_KNOWN;
  return message;
}

}  // namespace drive_detail

/// Adds the drive's messages to a bag that is open for writing.
inline void writeDrive(rosbag::Bag& bag, const Drive& drive) {
  using namespace drive_detail;
  const ros::Duration later(drive.recorded_later_s);
  for (int i = 0; i < kInputs; ++i) {
    const double time_s = drive.begin_s + kInput_s * i, x_m = kSpeed_mps * kInput_s * i;
    const ros::Time stamp(time_s), recorded = stamp + later;
    if (i == 0 && drive.has_tf) bag.write("/tf_static", recorded, laserTransform(stamp));
    const bool is_lost =
        kInput_s * i > drive.lost_motion_from_s && kInput_s * i < drive.lost_motion_to_s;
    if (drive.has_dead_reckoning && !is_lost) {
      const double told_s = drive.motion_has_stamps ? time_s + drive.motion_ahead_s : 0.0;
      bag.write("/dead_reckoning", recorded,
                toMessage(core::AckermannInput{told_s, kSpeed_mps, 0.0}, "base_link"));
    }
    if (drive.has_odom) {
      nav_msgs::Odometry odom;
      odom.header.stamp = stamp;
      odom.twist.twist.linear.x = kSpeed_mps;
      bag.write("/odom", recorded, odom);
    }
    if (i % kInputsPerScan != 0) continue;
    core::LaserScan scan = scanAt(x_m);
    scan.time_s = time_s;
    sensor_msgs::LaserScan message = toMessage(scan, "laser");
    if (drive.spoil) drive.spoil(message, i / kInputsPerScan);
    if (drive.has_scans) bag.write(drive.scan_topic, recorded, message);
    if (drive.has_points) {
      sensor_msgs::PointCloud2 cloud = cloudOf(scan);
      cloud.header = message.header;
      bag.write("/points", recorded, cloud);
    }
    if (drive.has_detections) {
      core::ObservationSet set = detectionsAt(x_m);
      set.time_s = time_s;
      bag.write("/detections", recorded, toMessage(set, "laser"));
    }
    if (drive.has_gps && i % 20 == 0) bag.write("/gps/fix", recorded, fixAt(stamp, x_m));
  }
}

/// A bag of one drive.
inline std::string writeDriveBag(const std::string& path, const Drive& drive) {
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  writeDrive(bag, drive);
  bag.close();
  return path;
}

}  // namespace hymm::test
