#pragma once

#include <string>

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include "ros/cause_log.h"

namespace hymm {

/// Why tf must not be given a transform; empty if it may. Of a stamp near the end of time tf2
/// throws in a thread of its own, which ends the process, and of other nonsense it complains each
/// time.
std::string problemOf(const geometry_msgs::TransformStamped& transform);

/// Fills a buffer of tf from `/tf` and `/tf_static`, in a thread of its own, with what can be used;
/// what cannot is counted.
class TransformReader {
 public:
  /// `tf` and `causes` outlive the object.
  TransformReader(tf2::BufferCore& tf, CauseLog& causes);
  ~TransformReader();

 private:
  void take(const ros::MessageEvent<const tf2_msgs::TFMessage>& event, bool is_static);

  tf2::BufferCore& tf_;
  CauseLog& causes_;
  ros::CallbackQueue queue_;
  ros::NodeHandle handle_;
  ros::Subscriber changing_, static_;
  ros::AsyncSpinner spinner_{1, &queue_};
};

}  // namespace hymm
