#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

#include <boost/function.hpp>
#include <boost/shared_array.hpp>
#include <ros/advertise_options.h>
#include <ros/node_handle.h>
#include <ros/serialization.h>
#include <ros/serialized_message.h>

namespace hymm {

/// Publishes what is large, to readers of whom one may hang. roscpp keeps what a reader has not
/// taken, bounded by the number of messages only; this knows how many bytes that is. While the
/// slowest reader has too much to take, isFull() asks the owner to wait, and to send what is then
/// new. If that reader takes nothing for long, all readers are disconnected: those that live come
/// back within moments, as new subscribers, and one that hung does when it goes on. Without a
/// master, which tells them how, they stay connected.
/// Not thread-safe. Not for latched topics, whose last message waits for ever.
class BoundedPublisher {
 public:
  struct Bound {
    std::size_t bytes = 8'000'000;
    double patience_s = 5.0;
  };

  BoundedPublisher() = default;
  /// The number of messages that `options` allow is without a meaning: no message is dropped.
  BoundedPublisher(ros::NodeHandle handle, const ros::AdvertiseOptions& options, Bound bound);

  template <class Message>
  void publish(const Message& message) {
    send([&message] { return ros::serialization::serializeMessage(message); });
  }

  std::uint32_t getNumSubscribers() const { return publisher_.getNumSubscribers(); }
  /// What the slowest reader has not taken, in bytes; without what new subscribers are served.
  std::size_t waitingBytes();
  bool isFull() { return waitingBytes() >= bound_.bytes; }

  /// Disconnects the readers if one has taken nothing for long; whether it did. To be called often,
  /// and not with a lock that the callbacks of new subscribers take: these are waited for.
  bool disconnectIfStuck(double steady_now_s);

 private:
  struct Sent {
    boost::shared_array<std::uint8_t> buffer;  ///< shared with the queues of all readers
    std::size_t bytes = 0;
  };

  void send(const boost::function<ros::SerializedMessage()>& serialize);
  void forgetTaken();

  ros::NodeHandle handle_;
  ros::AdvertiseOptions options_;
  Bound bound_;
  ros::Publisher publisher_;
  std::deque<Sent> waiting_;  ///< the oldest first
  std::size_t waiting_bytes_ = 0;
  bool has_progressed_ = true;  ///< since the last look
  double progress_s_ = 0.0;     ///< when it was seen last, or was not needed
};

}  // namespace hymm
