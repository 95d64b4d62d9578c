#pragma once

#include <Eigen/Core>

namespace hymm::core {

/// An observation that may be of a landmark.
struct Pairing {
  int observation = 0;  ///< index, from 0
  int landmark = 0;     ///< any number that tells landmarks apart
  Eigen::Vector2d innovation = Eigen::Vector2d::Zero();
  double cue_cost = 0.0;  ///< squared deviations of further cues (diameter), added to the distance
  /// Other objects that might be met at the innovation's place, per unit of the measurement's
  /// space.
  double chance_density = 0.0;
};

}  // namespace hymm::core
