#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <variant>

#include <hymm/DeadReckoning.h>
#include <hymm/LandmarkObservations.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/PointCloud2.h>

namespace hymm {

/// A message of any sensor.
using SensorMessage =
    std::variant<DeadReckoning::ConstPtr, nav_msgs::Odometry::ConstPtr,
                 sensor_msgs::LaserScan::ConstPtr, sensor_msgs::PointCloud2::ConstPtr,
                 LandmarkObservations::ConstPtr, sensor_msgs::NavSatFix::ConstPtr>;

/// Whether it is a scan, a cloud or a set of observations: what a filter answers with an estimate.
bool isScan(const SensorMessage& message);

/// The header of any message.
const std_msgs::Header& headerOf(const SensorMessage& message);

/// Messages on their way from the thread that receives them to the one that works on them, so that
/// receiving never waits for work. Bounded; what does not fit is dropped and counted. Thread-safe.
class SensorQueue {
 public:
  /// Clouds are a thousand times larger than other messages: these are a gigabyte or less.
  static constexpr std::size_t kMostClouds = 300;

  struct Counts {
    std::size_t dropped = 0;        ///< of all kinds
    std::size_t dropped_scans = 0;  ///< among them
  };

  explicit SensorQueue(std::size_t capacity) : capacity_(capacity) {}

  /// Returns whether it fitted.
  bool push(SensorMessage message);

  /// All messages, the oldest first; waits for one at most `timeout`.
  std::deque<SensorMessage> takeAll(std::chrono::milliseconds timeout);

  void clear();
  std::size_t size() const;
  Counts counts() const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::deque<SensorMessage> messages_;
  std::size_t capacity_;
  std::size_t clouds_ = 0;  ///< among the messages
  Counts counts_;
};

}  // namespace hymm
