#include "ros/bounded_publisher.h"

#include <utility>

#include <ros/master.h>
#include <ros/topic_manager.h>

namespace hymm {

BoundedPublisher::BoundedPublisher(ros::NodeHandle handle, const ros::AdvertiseOptions& options,
                                   Bound bound)
    : handle_(std::move(handle)), options_(options), bound_(bound) {
  options_.queue_size = 0;  // no bound by number
  ros::AdvertiseOptions resolved = options_;
  publisher_ = handle_.advertise(resolved);
}

/// Not by ros::Publisher, which keeps to itself the buffer that all readers share: once only
/// `waiting_` holds it, all of them have taken the message.
void BoundedPublisher::send(const boost::function<ros::SerializedMessage()>& serialize) {
  ros::SerializedMessage message;
  ros::TopicManager::instance()->publish(publisher_.getTopic(), serialize, message);
  if (!message.buf) return;  // nobody reads
  waiting_.push_back({message.buf, message.num_bytes});
  waiting_bytes_ += message.num_bytes;
}

void BoundedPublisher::forgetTaken() {
  while (!waiting_.empty() && waiting_.front().buffer.use_count() == 1) {
    waiting_bytes_ -= waiting_.front().bytes;
    waiting_.pop_front();
    has_progressed_ = true;
  }
}

std::size_t BoundedPublisher::waitingBytes() {
  forgetTaken();
  return waiting_bytes_;
}

bool BoundedPublisher::disconnectIfStuck(double steady_now_s) {
  if (!isFull() || has_progressed_) progress_s_ = steady_now_s;
  has_progressed_ = false;
  if (steady_now_s - progress_s_ < bound_.patience_s) return false;
  if (!ros::master::check()) {  // else advertising would wait for it, for ever
    progress_s_ = steady_now_s;
    return false;
  }
  publisher_.shutdown();
  waiting_.clear();
  waiting_bytes_ = 0;
  has_progressed_ = true;
  ros::AdvertiseOptions resolved = options_;
  publisher_ = handle_.advertise(resolved);
  return true;
}

}  // namespace hymm
