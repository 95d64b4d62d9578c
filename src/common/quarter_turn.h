#pragma once

#include <Eigen/Core>

namespace hymm::core {

/// `v` turned by 90 degrees to the left: how its end moves as it begins to turn, by rad.
inline Eigen::Vector2d turnedLeft(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

}  // namespace hymm::core
