#include "ros/sensor_queue.h"

#include <utility>

namespace hymm {
namespace {

bool isCloud(const SensorMessage& message) {
  return std::holds_alternative<sensor_msgs::PointCloud2::ConstPtr>(message);
}

}  // namespace

bool isScan(const SensorMessage& message) {
  return std::holds_alternative<sensor_msgs::LaserScan::ConstPtr>(message) || isCloud(message) ||
         std::holds_alternative<LandmarkObservations::ConstPtr>(message);
}

const std_msgs::Header& headerOf(const SensorMessage& message) {
  return std::visit([](const auto& pointer) -> const std_msgs::Header& { return pointer->header; },
                    message);
}

bool SensorQueue::push(SensorMessage message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const bool is_cloud = isCloud(message);
  if (messages_.size() >= capacity_ || (is_cloud && clouds_ >= kMostClouds)) {
    ++counts_.dropped;
    if (isScan(message)) ++counts_.dropped_scans;
    return false;
  }
  if (is_cloud) ++clouds_;
  messages_.push_back(std::move(message));
  filled_.notify_one();
  return true;
}

std::deque<SensorMessage> SensorQueue::takeAll(std::chrono::milliseconds timeout) {
  std::unique_lock<std::mutex> lock(mutex_);
  filled_.wait_for(lock, timeout, [this] { return !messages_.empty(); });
  clouds_ = 0;
  return std::exchange(messages_, {});
}

void SensorQueue::clear() {
  const std::lock_guard<std::mutex> lock(mutex_);
  messages_.clear();
  clouds_ = 0;
}

std::size_t SensorQueue::size() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return messages_.size();
}

SensorQueue::Counts SensorQueue::counts() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return counts_;
}

}  // namespace hymm
