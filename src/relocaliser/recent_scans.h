#pragma once

#include <deque>
#include <vector>

#include <Eigen/Core>

#include "relocaliser/density_map.h"

namespace hymm::core {

/// The scans of the last seconds as seen from where the vehicle is now, by the motion since:
/// together they tell a place better than one does. A faster sensor tells not more of a place,
/// since it shows the same landmarks from the same places: of its scans those count that are a
/// tenth of the time apart, and the newest.
class RecentScans {
 public:
  /// However slow the sensor is, so many scans are kept.
  static constexpr std::size_t kFewest = 5;

  explicit RecentScans(double duration_s) : duration_s_(duration_s) {}

  void clear() { scans_.clear(); }
  /// The vehicle moved by `T_then_now`, with this covariance in the axes of `then`.
  void move(const Pose2& T_then_now, const Eigen::Matrix3d& covariance);
  /// In order of time.
  void add(double time_s, std::vector<ObservedPoint> points);
  std::size_t size() const { return scans_.size(); }
  /// All points in the vehicle's present axes, known as little as the motion since makes them.
  std::vector<ObservedPoint> points() const;

 private:
  struct Scan {
    double time_s = 0.0;
    std::vector<ObservedPoint> points;  ///< in base axes of when it was taken
    Pose2 T_now_then;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of T_now_then, present axes
  };

  double duration_s_;
  std::deque<Scan> scans_;
};

}  // namespace hymm::core
