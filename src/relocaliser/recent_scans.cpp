#include "relocaliser/recent_scans.h"

#include <cmath>
#include <iterator>
#include <utility>

namespace hymm::core {
namespace {

constexpr double kParts = 10.0;
constexpr double kSameTime_s = 1e-3;  // stamps of a sensor's scans are not spaced to the bit

}  // namespace

void RecentScans::move(const Pose2& T_then_now, const Eigen::Matrix3d& covariance) {
  const Pose2 T_now_then = inverse(T_then_now);
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = T_now_then.rotation();
  const Eigen::Matrix3d added = turn * covariance * turn.transpose();
  for (Scan& scan : scans_) {
    scan.T_now_then = T_now_then * scan.T_now_then;
    scan.covariance = turn * scan.covariance * turn.transpose() + added;
  }
}

void RecentScans::add(double time_s, std::vector<ObservedPoint> points) {
  const double spacing_s = duration_s_ / kParts;
  const bool newest_is_near =
      scans_.size() >= 2 &&
      scans_.back().time_s - std::prev(scans_.end(), 2)->time_s < spacing_s - kSameTime_s;
  if (newest_is_near) scans_.pop_back();
  scans_.push_back({time_s, std::move(points), {}, Eigen::Matrix3d::Zero()});
  while (scans_.size() > kFewest && time_s - scans_.front().time_s > duration_s_ - kSameTime_s) {
    scans_.pop_front();
  }
}

std::vector<ObservedPoint> RecentScans::points() const {
  std::vector<ObservedPoint> all;
  for (const Scan& scan : scans_) {
    for (const ObservedPoint& point : scan.points) {
      const Eigen::Vector2d place = scan.T_now_then * point.p_base_point.cast<double>();
      const double variance = point.deviation_m * point.deviation_m +
                              scan.covariance.diagonal().head<2>().maxCoeff() +
                              scan.covariance(2, 2) * place.squaredNorm();
      all.push_back({place.cast<float>(), roundedUpDeviation(std::sqrt(variance)), point.range_m});
    }
  }
  return all;
}

}  // namespace hymm::core
