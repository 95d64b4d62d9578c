#pragma once

#include <algorithm>

#include <Eigen/Core>

#include "information_map/information_config.h"

namespace hymm::core {

/// How a landmark's region (an ellipse of `region_sigmas` deviations) looks from a place.
struct RegionView {
  double bearing_rad = 0.0;  ///< of the centre, in map axes
  double nearest_m = 0.0;    ///< no point of the region is nearer
  double farthest_m = 0.0;   ///< no point of the region is farther
  double left_rad = 0.0;     ///< from the centre to the region's left tangent
  double right_rad = 0.0;    ///< from the centre to the right tangent, positive
};

/// The region of a landmark at `offset` from the sensor [m], with its covariance [m^2]. Tangents
/// are exact; distances are those of the box around the region along and across the line of sight.
/// A region around the sensor fills all directions.
RegionView viewRegion(const Eigen::Vector2d& offset, const Eigen::Matrix2d& covariance,
                      double region_sigmas);

/// How far all of a region lies within the sensor's range, by the worst case of paper IV-C;
/// negative where a part of it lies outside.
inline double rangeMargin_m(const RegionView& view, const ExpectedSensor& sensor) {
  return std::min(sensor.range_m - view.farthest_m, view.nearest_m - sensor.min_range_m);
}

}  // namespace hymm::core
