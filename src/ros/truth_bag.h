#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "evaluation/trajectory.h"

namespace hymm {

/// What /truth/pose and /truth/landmarks of a simulated bag say, in the frame `map`.
struct Truth {
  std::vector<core::StampedPose> poses;    ///< empty without /truth/pose
  std::vector<Eigen::Vector2d> landmarks;  ///< m; empty without /truth/landmarks
};

/// Throws core::InputError if the bag cannot be read, or true poses are not in order of time.
Truth readTruth(const std::string& bag);

}  // namespace hymm
