#pragma once

#include <array>
#include <optional>
#include <unordered_map>

#include <Eigen/Core>

#include "information_map/level_cells.h"

namespace hymm::core {

/// Looks for islands of the level sets by climbing the information from exploration points near
/// landmarks that are not in the highest set (paper IV-A, IV-B). A climb is repeated when its
/// outcome does not hold any more.
class ExplorationPoints {
 public:
  explicit ExplorationPoints(double range_m) : range_m_(range_m) {}

  /// Cells of a higher level than held become seeds, from which the sets spread.
  void explore(LevelCells& cells);

 private:
  std::array<Eigen::Vector2d, 5> around(const Eigen::Vector2d& landmark) const;
  std::optional<Cell> climb(LevelCells& cells, const Eigen::Vector2d& start) const;

  double range_m_;
  std::unordered_map<int, Cell> summits_;  ///< where the climb from a landmark ended, by id
};

}  // namespace hymm::core
