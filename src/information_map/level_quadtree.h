#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "information_map/level_islands.h"
#include "information_map/level_lattice.h"

namespace hymm::core {

/// A square of a level set: a leaf of its quadtree. Its edge is a power of two of the lattice's
/// cells, its corners are multiples of its edge.
struct LevelLeaf {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< m
  double edge_m = 0.0;
  int island = -1;  ///< id
};

/// The leaves of a level set (22): as few squares as a quadtree over the lattice has. Together
/// they cover the cells of the set, each once.
std::vector<LevelLeaf> quadtreeLeaves(const LevelLattice& lattice, int level,
                                      const LevelIslands& islands);

}  // namespace hymm::core
