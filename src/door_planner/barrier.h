#pragma once

#include <utility>

#include <Eigen/Core>

namespace hymm::core {

/// A landmark as something that no vehicle passes: a disc.
struct SolidLandmark {
  int id = -1;
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< in map, m
  double diameter_m = 0.0;                          ///< NaN where it is not told

  bool operator==(const SolidLandmark& o) const {
    return id == o.id && place == o.place &&
           (diameter_m == o.diameter_m ||
            (diameter_m != diameter_m && o.diameter_m != o.diameter_m));
  }
};

/// What a vehicle keeps away from beside occupied cells: all within a radius of a stretch. A
/// landmark's stretch is its centre, twice; a border of the mesh has no width.
struct Barrier {
  std::pair<int, int> landmarks;  ///< at the ends of the stretch
  Eigen::Vector2d from, to;
  double radius_m = 0.0;

  bool isLandmark() const { return landmarks.first == landmarks.second; }
};

}  // namespace hymm::core
