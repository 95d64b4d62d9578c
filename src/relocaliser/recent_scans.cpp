#include "relocaliser/recent_scans.h"

#include <cmath>

namespace hymm::core {

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

void RecentScans::add(std::vector<ObservedPoint> points) {
  scans_.push_back({std::move(points), {}, Eigen::Matrix3d::Zero()});
  if (scans_.size() > most_) scans_.pop_front();
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
