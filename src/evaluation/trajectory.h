#pragma once

#include <cstddef>
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

/// Poses in order of time, to be asked for any time between.
class Trajectory {
 public:
  /// Throws std::invalid_argument if times do not increase strictly.
  explicit Trajectory(std::vector<StampedPose> poses);

  /// The pose at a time; nothing outside the trajectory, or where the poses around that time are
  /// farther apart than kLongestInterpolation_s.
  std::optional<Pose2> at(double time_s) const;

  const std::vector<StampedPose>& poses() const { return poses_; }

 private:
  std::vector<StampedPose> poses_;
};

}  // namespace hymm::core
