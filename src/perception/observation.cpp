#include "perception/observation.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {
namespace {

constexpr double kSmallestRange_m = 1e-3;

/// The vector turned left by a right angle: derivative of a rotated vector by the angle.
Eigen::Vector2d turnedLeft(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

}  // namespace

Observation asOfStamp(const Observation& observation, const Pose2& T_stamp_sensor,
                      const Eigen::Matrix3d& covariance) {
  const double direction = T_stamp_sensor.yaw_rad + observation.bearing_rad;
  const Eigen::Vector2d along(std::cos(direction), std::sin(direction));
  const Eigen::Vector2d from_sensor = observation.range_m * along;
  const Eigen::Vector2d place = T_stamp_sensor.position() + from_sensor;
  const double range_m = std::max(place.norm(), kSmallestRange_m);

  Eigen::Matrix2d to_place;  // d(place)/d(range, bearing)
  to_place << along, turnedLeft(from_sensor);
  Eigen::Matrix2d to_polar;  // d(range, bearing as of the stamp)/d(place)
  to_polar << place.transpose() / range_m, turnedLeft(place).transpose() / (range_m * range_m);
  Eigen::Matrix<double, 2, 3> by_pose;  // d(place)/d(pose)
  by_pose << Eigen::Matrix2d::Identity(), turnedLeft(from_sensor);

  const Eigen::Matrix2d J = to_polar * to_place;
  const Eigen::Matrix<double, 2, 3> J_pose = to_polar * by_pose;
  Observation seen = observation;
  seen.after_stamp_s = 0.0;
  seen.range_m = range_m;
  seen.bearing_rad = std::atan2(place.y(), place.x());
  seen.covariance =
      J * observation.covariance * J.transpose() + J_pose * covariance * J_pose.transpose();
  seen.diameter_covariance = J * observation.diameter_covariance;
  return seen;
}

}  // namespace hymm::core
