#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>

#include "ros/steady_time.h"

namespace hymm {

/// Counts what comes on the topics that a node listens to, and tells it in diagnostics: how much,
/// how often, how long ago. Thread-safe.
class TrafficMeter {
 public:
  /// `clock` tells seconds, of the wall.
  explicit TrafficMeter(std::function<double()> clock = steadyNow) : clock_(std::move(clock)) {}

  /// Counts what comes on the resolved name `topic` from now on.
  void watch(const std::string& topic);
  /// The same; and where nothing comes on it, diagnostics warn of that.
  void expect(const std::string& topic);
  void note(const std::string& topic);

  /// Subscribes as the handle would, and counts.
  template <class Message>
  ros::Subscriber subscribe(ros::NodeHandle& handle, const std::string& topic, std::uint32_t queue,
                            boost::function<void(const boost::shared_ptr<const Message>&)> take,
                            const ros::TransportHints& hints = ros::TransportHints()) {
    const std::string name = handle.resolveName(topic);
    watch(name);
    const boost::function<void(const boost::shared_ptr<const Message>&)> counted =
        [this, name, take](const boost::shared_ptr<const Message>& message) {
          note(name);
          take(message);
        };
    return handle.subscribe<Message>(topic, queue, counted, ros::VoidConstPtr(), hints);
  }
  template <class Message, class Node>
  ros::Subscriber subscribe(ros::NodeHandle& handle, const std::string& topic, std::uint32_t queue,
                            void (Node::*take)(const Message&), Node* node,
                            const ros::TransportHints& hints = ros::TransportHints()) {
    return subscribe<Message>(
        handle, topic, queue,
        [node, take](const boost::shared_ptr<const Message>& message) { (node->*take)(*message); },
        hints);
  }

  /// Adds what came; rates are of the time since the last call.
  void addTo(diagnostic_updater::DiagnosticStatusWrapper& status);
  /// The same as a status of its own.
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

 private:
  struct Topic {
    bool is_expected = false;
    std::size_t messages = 0;
    std::size_t messages_told = 0;
    double last_s = 0.0;  ///< when the last one came; when the watch began, before the first
    double told_s = 0.0;
  };

  std::function<double()> clock_;
  std::mutex mutex_;
  std::map<std::string, Topic> topics_;
};

}  // namespace hymm
