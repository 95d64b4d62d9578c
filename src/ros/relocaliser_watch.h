#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <hymm/RelocaliserHealth.h>
#include <ros/node_handle.h>

#include "ros/wish_numbers.h"
#include "supervisor/supervisor_decision.h"

namespace hymm {

/// What the relocaliser tells, for the supervisor to decide on.
class RelocaliserWatch {
 public:
  /// `heard` is called whenever something new was told.
  RelocaliserWatch(ros::NodeHandle handle, std::function<void()> heard);

  /// What it says of an order; nothing if it was never heard.
  std::optional<core::RelocaliserEvidence> evidence(std::uint64_t order, double steady_now_s) const;
  /// Whether what it told last is of that order.
  bool knows(std::uint64_t order) const { return health_ && health_->order == order; }
  /// Whether nothing more is to be waited for before the scan at `stamp` is judged.
  bool hasAnswered(std::uint64_t order, const ros::Time& stamp) const;
  /// Its pose of that scan, where it told one.
  std::optional<geometry_msgs::PoseWithCovariance> poseAt(const ros::Time& stamp) const;
  /// Whether an operator asked for a search since the last call.
  bool takeWish() { return wishes_.takeNew(); }

 private:
  void takeHealth(const RelocaliserHealth& message);
  void takePose(const geometry_msgs::PoseWithCovarianceStamped& message);

  std::function<void()> heard_;
  std::optional<RelocaliserHealth> health_;
  double heard_wall_s_ = 0.0;
  std::deque<geometry_msgs::PoseWithCovarianceStamped> poses_;  ///< the last
  WishListener wishes_;
  ros::Subscriber health_subscriber_, pose_subscriber_;
};

}  // namespace hymm
