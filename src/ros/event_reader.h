#pragma once

#include <optional>
#include <string>

#include "perception/point_scan.h"
#include "pipeline/sensor_event.h"
#include "ros/cause_log.h"
#include "ros/gps_converter.h"
#include "ros/odometry_reader.h"
#include "ros/sensor_mountings.h"
#include "ros/sensor_queue.h"
#include "ros/untimed_turns.h"

namespace hymm {

/// Turns sensor messages into events of the core, with the place of the sensor; refuses and counts
/// those that have no place or no time.
class EventReader {
 public:
  struct Answer {
    std::optional<core::SensorEvent> event;
    bool waiting = false;  ///< tf may yet tell where the sensor stands: ask again with this message
  };

  /// `points`: how clouds become scans. `use_time_increment`: whether to believe what scans tell of
  /// how long they take.
  EventReader(SensorMountings mountings, GpsConverter gps, const core::PointCloudConfig& points,
              bool use_time_increment, CauseLog& causes);

  Answer read(const SensorMessage& message, double steady_now_s);

  /// What is to be said of the whole, beside what was counted: a sentence, or nothing.
  std::string summary() const { return turns_.summary(); }

  /// Another recording begins.
  void reset();

 private:
  Answer readMotion(const core::MotionInput& input);
  Answer readOdometry(const nav_msgs::Odometry& message, double steady_now_s);
  std::optional<core::SensorEvent> readGps(const sensor_msgs::NavSatFix& message);
  void checkScan(const sensor_msgs::LaserScan& message, core::LaserScan& scan);
  template <class Message>
  Answer readPlaced(const Message& message, double steady_now_s);
  Answer readCloud(const sensor_msgs::PointCloud2& message, double steady_now_s);

  SensorMountings mountings_;
  GpsConverter gps_;
  OdometryReader odometry_;
  core::PointCloudConfig points_;
  bool use_time_increment_;
  UntimedTurns turns_;
  CauseLog& causes_;
};

}  // namespace hymm
