#include "ros/event_reader.h"

#include <type_traits>
#include <utility>

#include "perception/scan_check.h"
#include "ros/cloud_conversions.h"
#include "ros/sensor_conversions.h"

namespace hymm {
namespace {

core::SensorEvent placed(core::LaserScan scan, const core::Pose2& T_base_sensor) {
  return core::ScanEvent{std::move(scan), T_base_sensor};
}

core::SensorEvent placed(core::ObservationSet set, const core::Pose2& T_base_sensor) {
  set.T_base_sensor = T_base_sensor;
  return set;
}

}  // namespace

EventReader::EventReader(SensorMountings mountings, GpsConverter gps,
                         const core::PointCloudConfig& points, bool use_time_increment,
                         CauseLog& causes)
    : mountings_(std::move(mountings)),
      gps_(std::move(gps)),
      points_(points),
      use_time_increment_(use_time_increment),
      causes_(causes) {}

EventReader::Answer EventReader::read(const SensorMessage& message, double steady_now_s) {
  return std::visit(
      [&](const auto& pointer) -> Answer {
        using Message = std::remove_const_t<typename std::decay_t<decltype(pointer)>::element_type>;
        if (pointer->header.stamp.isZero()) {
          causes_.count("no time stamp", "A message of frame '" + pointer->header.frame_id +
                                             "' has the stamp 0, which means none; it is refused.");
          return {};
        }
        if constexpr (std::is_same_v<Message, DeadReckoning>) {
          return readMotion(fromMessage(*pointer));
        } else if constexpr (std::is_same_v<Message, nav_msgs::Odometry>) {
          return readOdometry(*pointer, steady_now_s);
        } else if constexpr (std::is_same_v<Message, sensor_msgs::NavSatFix>) {
          return {readGps(*pointer), false};
        } else if constexpr (std::is_same_v<Message, sensor_msgs::PointCloud2>) {
          return readCloud(*pointer, steady_now_s);
        } else {
          return readPlaced(*pointer, steady_now_s);
        }
      },
      message);
}

EventReader::Answer EventReader::readMotion(const core::MotionInput& input) {
  turns_.take(input);
  return {input, false};
}

template <class Message>
EventReader::Answer EventReader::readPlaced(const Message& message, double steady_now_s) {
  const SensorMountings::Answer mounting = mountings_.find(message.header.frame_id, steady_now_s);
  if (mounting.waiting) return {std::nullopt, true};
  if (!mounting.T_base_sensor) {
    causes_.count("unknown frame '" + message.header.frame_id + "'",
                  "Scans or detections of frame '" + message.header.frame_id +
                      "' are refused: " + mounting.problem + ".");
    return {};
  }
  if (!mounting.assumed.empty()) {
    causes_.count("scans or detections of frame '" + message.header.frame_id +
                      "' placed as the vehicle's description says",
                  "Scans or detections of frame '" + message.header.frame_id +
                      "': " + mounting.assumed + ".");
  }
  auto measurement = fromMessage(message);
  if (mounting.upside_down) turnUpright(measurement);
  if constexpr (std::is_same_v<Message, sensor_msgs::LaserScan>) checkScan(message, measurement);
  return {placed(std::move(measurement), *mounting.T_base_sensor), false};
}

/// Tells of what is wrong in parts of a scan, and takes out of it what would do harm.
void EventReader::checkScan(const sensor_msgs::LaserScan& message, core::LaserScan& scan) {
  const std::string a_scan = "A scan of frame '" + message.header.frame_id + "'";
  if (core::invalidRanges(scan) > 0) {
    causes_.count("scans with negative ranges",
                  a_scan +
                      " has negative ranges, which mean nothing (REP-117); these beams are "
                      "taken for ones without a measurement.");
  }
  if (!message.intensities.empty() && message.intensities.size() != message.ranges.size()) {
    causes_.count("scans whose intensities are not as many as their ranges",
                  a_scan + " has " + std::to_string(message.intensities.size()) +
                      " intensities for " + std::to_string(message.ranges.size()) +
                      " ranges; the ranges are used, the intensities are not: reflectors cannot be "
                      "seen in it.");
  }
  if (!use_time_increment_) scan.time_increment_s = 0.0;
  if (const auto problem = core::sweepProblem(scan, static_cast<double>(message.scan_time))) {
    scan.time_increment_s = 0.0;
    causes_.count("scans with an unusable time_increment",
                  a_scan + " cannot say when its beams were measured: " + *problem +
                      " They are all taken as measured at its stamp.");
  }
  const double period_s = static_cast<double>(message.scan_time);
  if (use_time_increment_ && scan.sweep_s() == 0.0 && period_s > 0.0) {
    turns_.take(scan, period_s, message.header.frame_id, causes_);
  }
}

EventReader::Answer EventReader::readCloud(const sensor_msgs::PointCloud2& message,
                                           double steady_now_s) {
  const SensorMountings::Answer mounting =
      mountings_.findInSpace(message.header.frame_id, steady_now_s);
  if (mounting.waiting) return {std::nullopt, true};
  const CloudScan cloud = scanOfCloud(message, mounting, points_);
  for (const auto& remark : cloud.remarks) causes_.count(remark.cause, remark.problem);
  if (!cloud.scan) return {};
  core::LaserScan scan = cloud.scan->scan;
  if (!use_time_increment_) {
    scan.time_s = cloud.scan->told_stamp.toSec();
    scan.beam_times_s.clear();
  } else if (scan.sweep_s() == 0.0) {
    turns_.take(scan, std::nullopt, message.header.frame_id, causes_);
  }
  return {placed(std::move(scan), *mounting.T_base_sensor), false};
}

EventReader::Answer EventReader::readOdometry(const nav_msgs::Odometry& message,
                                              double steady_now_s) {
  const OdometryReader::Answer answer = odometry_.read(message, mountings_, steady_now_s, causes_);
  if (!answer.input) return {std::nullopt, answer.waiting};
  return readMotion(*answer.input);
}

std::optional<core::SensorEvent> EventReader::readGps(const sensor_msgs::NavSatFix& message) {
  GpsConverter::Answer answer = gps_.convert(message);
  if (!answer.fix) {
    causes_.count("GPS fix refused", "A GPS fix is refused: " + answer.problem + ".");
    return std::nullopt;
  }
  if (!answer.problem.empty()) causes_.count("GPS fix without covariance", answer.problem);
  return core::SensorEvent(*answer.fix);
}

void EventReader::reset() {
  mountings_.reset();
  gps_.reset();
  odometry_.reset();
  turns_.reset();
}

}  // namespace hymm
