#pragma once

#include <optional>
#include <vector>

#include "evaluation/error_statistics.h"
#include "evaluation/trajectory.h"

namespace hymm::core {

/// A point at a time, for instance a GPS fix in local metres.
struct StampedPosition {
  double time_s = 0.0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
};

/// How far GPS fixes lie from the antenna's estimated place.
struct GpsErrors {
  ErrorStatistics distance_m;
  std::size_t unreachable = 0;   ///< fixes left out by FixGate
  std::size_t without_pose = 0;  ///< in the window, but no pose to compare them with
  Pose2 T_gps_map;               ///< the alignment
};

/// Compares each fix of the window with the antenna's place (`p_base_antenna`, in base_link),
/// interpolated from the trajectory, after the one rigid motion of the plane that brings the two
/// nearest to each other. FixGate goes through all fixes, whatever the window, so that a window
/// does not change which fixes count. Nothing with fewer than three fixes to compare.
std::optional<GpsErrors> computeGpsErrors(const Trajectory& T_map_base,
                                          const std::vector<StampedPosition>& fixes,
                                          const Eigen::Vector2d& p_base_antenna,
                                          const TimeWindow& window);

}  // namespace hymm::core
