#pragma once

#include <Eigen/Core>

#include "hybrid_map/ltr_geometry.h"

namespace hymm::core {

// The paper's bounds of the shape, from the sides alone at one sigma, to compare with shapeFactor()
// (hybrid_map/ltr_geometry.h), which bounds every direction at three. Lengths along other
// directions than the sides can grow by more than these say. `covariance`: of the corners together.

/// K of (16): 1 + the largest share that the deviation of a side's vector is of its length.
double sideVectorBound(const Corners& corners, const Eigen::Matrix<double, 6, 6>& covariance);

/// K of (17), with the deviations of the sides' lengths as in (18).
double sideLengthBound(const Corners& corners, const Eigen::Matrix<double, 6, 6>& covariance);

}  // namespace hymm::core
