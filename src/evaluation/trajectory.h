#pragma once

#include <algorithm>
#include <iterator>
#include <optional>
#include <vector>

#include "common/pose2.h"

namespace hymm::core {

/// A pose at a time.
struct StampedPose {
  double time_s = 0.0;
  Pose2 pose;
};

/// Longest time between two poses across which a pose is interpolated. Over it a car at 5 m/s and
/// 1 m/s^2 leaves the chord by at most an eighth of a metre.
inline constexpr double kLongestInterpolation_s = 1.0;

/// The pose between two: position along the straight line, yaw along the shorter way.
Pose2 interpolate(const StampedPose& before, const StampedPose& after, double time_s);

/// The pose at a time, of poses in order of time; nothing outside of them, or where the poses
/// around that time are farther apart than kLongestInterpolation_s.
template <class StampedPoses>
std::optional<Pose2> poseAt(const StampedPoses& poses, double time_s) {
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), time_s,
                       [](const StampedPose& pose, double time) { return pose.time_s < time; });
  if (after == poses.end()) return std::nullopt;
  if (after->time_s == time_s) return after->pose;
  if (after == poses.begin()) return std::nullopt;
  const StampedPose& before = *std::prev(after);
  if (after->time_s - before.time_s > kLongestInterpolation_s) return std::nullopt;
  return interpolate(before, *after, time_s);
}

/// Poses in order of time, to be asked for any time between.
class Trajectory {
 public:
  /// Throws std::invalid_argument if times do not increase strictly.
  explicit Trajectory(std::vector<StampedPose> poses);

  /// As poseAt().
  std::optional<Pose2> at(double time_s) const { return poseAt(poses_, time_s); }

  const std::vector<StampedPose>& poses() const { return poses_; }

 private:
  std::vector<StampedPose> poses_;
};

}  // namespace hymm::core
