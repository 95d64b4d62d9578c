#include "ros/relocaliser_watch.h"

#include <algorithm>
#include <utility>

#include "ros/relocaliser_conversions.h"
#include "ros/steady_time.h"

namespace hymm {
namespace {

constexpr std::uint32_t kQueue = 1000;
constexpr std::size_t kMostPoses = 1000;

}  // namespace

RelocaliserWatch::RelocaliserWatch(ros::NodeHandle handle, std::function<void()> heard)
    : heard_(std::move(heard)), wishes_(ros::WallTime::now()) {
  const auto hints = ros::TransportHints().tcpNoDelay();
  pose_subscriber_ =
      handle.subscribe("relocaliser/pose", kQueue, &RelocaliserWatch::takePose, this, hints);
  health_subscriber_ =
      handle.subscribe("relocaliser/health", kQueue, &RelocaliserWatch::takeHealth, this, hints);
}

void RelocaliserWatch::takeHealth(const RelocaliserHealth& message) {
  wishes_.take(message.wish);
  health_ = message;
  heard_wall_s_ = steadyNow();
  heard_();
}

void RelocaliserWatch::takePose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  poses_.push_back(message);
  if (poses_.size() > kMostPoses) poses_.pop_front();
  heard_();
}

std::optional<core::RelocaliserEvidence> RelocaliserWatch::evidence(std::uint64_t order,
                                                                    double steady_now_s) const {
  if (!health_) return std::nullopt;
  core::RelocaliserEvidence evidence;
  if (health_->order == order) evidence = evidenceFrom(*health_);
  evidence.age_s = steady_now_s - heard_wall_s_;
  return evidence;
}

bool RelocaliserWatch::hasAnswered(std::uint64_t order, const ros::Time& stamp) const {
  if (!health_ || health_->order != order) return false;
  if (health_->state != RelocaliserHealth::SEARCHING) return true;
  if (health_->header.stamp < stamp) return false;
  // The pose comes on a topic of its own, perhaps later; without particles there is none.
  return health_->particles == 0 || poseAt(stamp) || health_->header.stamp > stamp;
}

std::optional<geometry_msgs::PoseWithCovariance> RelocaliserWatch::poseAt(
    const ros::Time& stamp) const {
  const auto found = std::find_if(poses_.rbegin(), poses_.rend(),
                                  [&](const auto& pose) { return pose.header.stamp == stamp; });
  if (found == poses_.rend()) return std::nullopt;
  return found->pose;
}

}  // namespace hymm
