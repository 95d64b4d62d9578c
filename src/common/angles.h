#pragma once

#include <cmath>

namespace hymm::core {

inline constexpr double kPi = 3.14159265358979323846;

/// The same direction within [-pi, pi].
inline double wrapAngle(double angle_rad) { return std::remainder(angle_rad, 2.0 * kPi); }

}  // namespace hymm::core
