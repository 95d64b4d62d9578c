#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>

#include <sensor_msgs/NavSatFix.h>
#include <visualization_msgs/Marker.h>

#include "common/pose2.h"
#include "evaluation/fix_gate.h"
#include "evaluation/rigid_alignment.h"
#include "evaluation/trajectory.h"
#include "ros/gps_converter.h"

namespace hymm {

/// GPS fixes as points in the map, to compare the trajectory with by eye. The map's origin and
/// heading are the vehicle's first pose, which GPS does not know: the fixes' east-north frame is
/// therefore laid over the map by the rigid motion that brings all fixes nearest to the antenna's
/// estimated places, again after each fix. The filter never sees any of it.
class GpsOverlay {
 public:
  /// `antenna`: its place in base_link.
  GpsOverlay(const Eigen::Vector2d& antenna, std::string map_frame);

  /// Poses in order of time.
  void addPose(double time_s, const core::Pose2& T_map_base);

  /// Fixes in order of time, before or a little after the poses around them. Fixes that cannot be
  /// used, that the vehicle cannot have reached, or that are stamped far ahead of the next are left
  /// out.
  void addFix(const sensor_msgs::NavSatFix& message);

  /// Fixes that have a place in the map.
  std::size_t count() const;

  /// The fixes in the map; a deletion as long as too few of them tell how to lay them.
  visualization_msgs::Marker marker() const;

  /// Poses and fixes from here on belong to another map.
  void clear();

 private:
  void compareWaiting();

  Eigen::Vector2d antenna_;
  std::string map_frame_;
  GpsConverter converter_;
  core::FixGate gate_;
  std::deque<core::StampedPose> poses_;  ///< of the last seconds
  std::deque<core::GpsFix> waiting_;     ///< for a pose at or past their stamp, by time
  core::RigidAlignment alignment_;       ///< of fixes (from) to antenna places in the map (to)
  std::deque<Eigen::Vector2d> fixes_;    ///< compared ones, east-north [m]; the newest
  double time_s_ = 0.0;
};

}  // namespace hymm
