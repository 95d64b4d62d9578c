#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "hybrid_map/ltr_geometry.h"
#include "hybrid_map/ltr_mesh.h"

namespace hymm::core {

/// What the planner knows of an LTR: who spans it, where, and how finely its cells divide it. Side
/// k runs from vertex k to vertex k + 1 (modulo 3).
struct LtrView {
  int id = kNone;
  std::array<int, 3> landmark_ids{};  ///< counter-clockwise; the first is L_1 of (2)
  std::array<int, 3> neighbours{kNone, kNone, kNone};  ///< across each side, by id
  Corners corners{Eigen::Vector2d(0, 0), Eigen::Vector2d(0, 0),
                  Eigen::Vector2d(0, 0)};  ///< in map, m
  int alpha_cells = 1, beta_cells = 1;     ///< of its TriangularGrid
  double shape_factor = 1.0;               ///< K; NaN where it is not known

  /// By which its costs are multiplied.
  double factor() const { return std::isnan(shape_factor) ? 1.0 : std::max(1.0, shape_factor); }
};

/// What its cells hold, in the order of its TriangularGrid. NaN where nothing is known.
struct LtrContent {
  std::vector<float> occupancy;  ///< probability; empty: nothing is known
  /// Values of further layers by name ("traffic", "height"), of a category layer the share of each
  /// category ("terrain.grass").
  std::map<std::string, std::vector<float>> properties;
};

}  // namespace hymm::core
