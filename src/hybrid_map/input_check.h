#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "cekf/landmark_map.h"

namespace hymm::core {

/// Coordinates beyond this [m] are no place on earth; they are refused.
constexpr double kFarthest_m = 1e7;

/// Whether a place in map is finite and on earth.
inline bool isPlace(const Eigen::Vector2d& place) {
  return place.allFinite() && place.cwiseAbs().maxCoeff() <= kFarthest_m;
}

/// Why landmarks cannot be used; nothing if they can: a position or covariance that is not finite,
/// an id that is negative, or not in ascending order (twice the same, for instance).
std::optional<std::string> landmarkProblem(const std::vector<LandmarkEstimate>& landmarks);

}  // namespace hymm::core
