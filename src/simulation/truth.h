#pragma once

#include <vector>

#include <Eigen/Core>

#include "perception/observation.h"

namespace hymm::core {

/// A landmark as it stands in the world: something slim that sensors can find again.
struct TrueLandmark {
  int id = -1;
  LandmarkType type = LandmarkType::kUnknown;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< of its centre in map, m
  double diameter_m = 0.0;
};

/// The static solid world as cells in map axes: row-major from the corner of least x and y.
struct TrueOccupancy {
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  ///< least corner of cell (0, 0) in map, m
  double resolution_m = 0.0;
  int width = 0;   ///< cells along x
  int height = 0;  ///< cells along y
  std::vector<bool> occupied;
};

}  // namespace hymm::core
