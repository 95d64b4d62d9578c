#pragma once

#include <deque>
#include <vector>

#include <Eigen/Core>

#include "relocaliser/density_map.h"

namespace hymm::core {

/// The last scans as seen from where the vehicle is now, by the motion since: together they tell a
/// place better than one does.
class RecentScans {
 public:
  explicit RecentScans(std::size_t most) : most_(most) {}

  void clear() { scans_.clear(); }
  /// The vehicle moved by `T_then_now`, with this covariance in the axes of `then`.
  void move(const Pose2& T_then_now, const Eigen::Matrix3d& covariance);
  void add(std::vector<ObservedPoint> points);
  std::size_t size() const { return scans_.size(); }
  /// All points in the vehicle's present axes, known as little as the motion since makes them.
  std::vector<ObservedPoint> points() const;

 private:
  struct Scan {
    std::vector<ObservedPoint> points;  ///< in base axes of when it was taken
    Pose2 T_now_then;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of T_now_then, present axes
  };

  std::size_t most_;
  std::deque<Scan> scans_;
};

}  // namespace hymm::core
