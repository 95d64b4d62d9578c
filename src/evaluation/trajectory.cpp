#include "evaluation/trajectory.h"

#include <stdexcept>

#include "common/number_text.h"

namespace hymm::core {

Pose2 interpolate(const StampedPose& before, const StampedPose& after, double time_s) {
  const double span_s = after.time_s - before.time_s;
  const double share = span_s > 0.0 ? (time_s - before.time_s) / span_s : 0.0;
  const Eigen::Vector2d p =
      before.pose.position() + share * (after.pose.position() - before.pose.position());
  const double turn_rad = wrapAngle(after.pose.yaw_rad - before.pose.yaw_rad);
  return {p.x(), p.y(), wrapAngle(before.pose.yaw_rad + share * turn_rad)};
}

Trajectory::Trajectory(std::vector<StampedPose> poses) : poses_(std::move(poses)) {
  for (std::size_t i = 1; i < poses_.size(); ++i) {
    if (!(poses_[i].time_s > poses_[i - 1].time_s)) {
      throw std::invalid_argument("The trajectory's time does not increase at " +
                                  numberText(poses_[i].time_s) + " s.");
    }
  }
}

}  // namespace hymm::core
