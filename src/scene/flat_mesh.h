#pragma once

#include <vector>

#include <Eigen/Core>

#include "scene/colour.h"

namespace hymm::core {

/// Corners in the plane of the map [m], each with its colour: triangles where three, lines where
/// two follow one another.
struct FlatVertices {
  std::vector<Eigen::Vector2f> positions;
  std::vector<Pixel> colours;

  void add(const Eigen::Vector2d& position, const Pixel& colour) {
    positions.push_back(position.cast<float>());
    colours.push_back(colour);
  }
};

}  // namespace hymm::core
