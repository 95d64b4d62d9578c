#include "evaluation/trajectory.h"

#include <algorithm>
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

std::optional<Pose2> Trajectory::at(double time_s) const {
  const auto after =
      std::lower_bound(poses_.begin(), poses_.end(), time_s,
                       [](const StampedPose& pose, double time) { return pose.time_s < time; });
  if (after == poses_.end()) return std::nullopt;
  if (after->time_s == time_s) return after->pose;
  if (after == poses_.begin()) return std::nullopt;
  const auto before = after - 1;
  if (after->time_s - before->time_s > kLongestInterpolation_s) return std::nullopt;
  return interpolate(*before, *after, time_s);
}

}  // namespace hymm::core
