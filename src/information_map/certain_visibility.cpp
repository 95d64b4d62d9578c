#include "information_map/certain_visibility.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {

RegionView viewRegion(const Eigen::Vector2d& offset, const Eigen::Matrix2d& covariance,
                      double region_sigmas) {
  RegionView view;
  const double distance = offset.norm();
  view.bearing_rad = std::atan2(offset.y(), offset.x());
  const double c = distance > 0.0 ? offset.x() / distance : 1.0;
  const double s = distance > 0.0 ? offset.y() / distance : 0.0;
  // Covariance along (rr) and across (tt) the line of sight, times the squared number of sigmas.
  const double k2 = region_sigmas * region_sigmas;
  const double xx = k2 * covariance(0, 0), xy = k2 * covariance(0, 1), yy = k2 * covariance(1, 1);
  const double rr = std::max(0.0, c * c * xx + 2.0 * c * s * xy + s * s * yy);
  const double tt = std::max(0.0, s * s * xx - 2.0 * c * s * xy + c * c * yy);
  const double rt = c * s * (yy - xx) + (c * c - s * s) * xy;

  view.nearest_m = std::max(0.0, distance - std::sqrt(rr));
  view.farthest_m = std::hypot(distance + std::sqrt(rr), std::sqrt(tt));

  // A line through the sensor with normal n touches the ellipse where (n.d)^2 = k^2 n'Pn. With
  // t = tan of the angle from the line of sight: (d^2 - rr) t^2 + 2 rt t - tt = 0.
  const double a = distance * distance - rr;
  if (a <= 0.0) {
    view.left_rad = view.right_rad = kPi;
    return view;
  }
  const double root = std::sqrt(rt * rt + a * tt);
  view.left_rad = std::atan2(-rt + root, a);
  view.right_rad = std::atan2(rt + root, a);
  return view;
}

}  // namespace hymm::core
