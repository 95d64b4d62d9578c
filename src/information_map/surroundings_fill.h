#pragma once

#include <vector>

#include <Eigen/Core>

#include "information_map/level_cells.h"

namespace hymm::core {

/// Level sets from scratch: a quadtree from above over what is within reach of a landmark, the
/// surroundings of the vehicle first. Can be interrupted where the evaluations of an update end.
class SurroundingsFill {
 public:
  /// Nothing to fill.
  SurroundingsFill() = default;

  SurroundingsFill(const LandmarkField& field, const LevelLattice& lattice, double reach_m,
                   const Eigen::Vector2d& vehicle);

  bool isDone() const { return waiting_.empty(); }

  /// Goes on while there are evaluations.
  void goOn(LevelCells& cells);

 private:
  std::vector<Cell> waiting_;  ///< first cells of blocks; the last one is next
};

}  // namespace hymm::core
