#include "ros/transform_watch.h"

#include <ros/this_node.h>

namespace hymm {
namespace {

constexpr std::size_t kMostOthers = 64;  // nodes that are started anew may have new names

}  // namespace

TransformWatch::TransformWatch(ros::NodeHandle handle, const std::string& child_frame)
    : child_frame_(child_frame) {
  tf_ = handle.subscribe("/tf", 1000, &TransformWatch::take, this);
  tf_static_ = handle.subscribe("/tf_static", 100, &TransformWatch::take, this);
}

void TransformWatch::take(const ros::MessageEvent<const tf2_msgs::TFMessage>& event) {
  if (event.getPublisherName() == ros::this_node::getName()) return;
  for (const auto& transform : event.getConstMessage()->transforms) {
    if (transform.child_frame_id != child_frame_) continue;
    if (others_.size() >= kMostOthers && others_.count(event.getPublisherName()) == 0) continue;
    if (++others_[event.getPublisherName()] == 1) {
      ROS_ERROR_STREAM("Node " << event.getPublisherName() << " publishes '"
                               << transform.header.frame_id << "' -> '" << child_frame_
                               << "', too; only the supervisor may. Stop one of them.");
    }
  }
}

}  // namespace hymm
