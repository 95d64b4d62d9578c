#pragma once

#include <map>
#include <string>

#include <ros/node_handle.h>
#include <tf2_msgs/TFMessage.h>

namespace hymm {

/// Finds out who else publishes one transform: two publishers make a frame jump to and fro.
class TransformWatch {
 public:
  /// Watches for anybody but this node who gives `child_frame` a parent.
  TransformWatch(ros::NodeHandle handle, const std::string& child_frame);

  /// Names of the others and how many transforms came from each.
  const std::map<std::string, std::size_t>& others() const { return others_; }

 private:
  void take(const ros::MessageEvent<const tf2_msgs::TFMessage>& event);

  std::string child_frame_;
  std::map<std::string, std::size_t> others_;
  ros::Subscriber tf_, tf_static_;
};

}  // namespace hymm
