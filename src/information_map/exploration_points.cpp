#include "information_map/exploration_points.h"

#include <algorithm>
#include <utility>

namespace hymm::core {

using Eigen::Vector2d;

void ExplorationPoints::explore(LevelCells& cells) {
  const LandmarkField& field = cells.field();
  LevelLattice& lattice = cells.lattice();
  for (int i = 0; i < field.size() && cells.mayEvaluate(); ++i) {
    const Vector2d& place = field.position(i);
    if (lattice.levelAt(place) == lattice.levels()) continue;
    const auto summit = summits_.find(field.id(i));
    if (summit != summits_.end() && cells.holds(summit->second)) continue;
    std::optional<Cell> highest;
    for (const Vector2d& start : around(place)) {
      const std::optional<Cell> reached = climb(cells, start);
      if (!reached) return;
      if (!highest || cells.certificate(*reached).value > cells.certificate(*highest).value)
        highest = reached;
    }
    summits_[field.id(i)] = *highest;
    cells.certificates()
        .tile(cells.tileOf(*highest))
        .certificates[std::size_t(LevelLattice::indexInTile(*highest))]
        .is_summit = true;
    cells.spread();
  }
}

/// At a landmark, and half a range from it on four sides.
std::array<Vector2d, 5> ExplorationPoints::around(const Vector2d& landmark) const {
  const double far_m = 0.5 * range_m_;
  return {landmark, landmark + Vector2d(far_m, 0.0), landmark - Vector2d(far_m, 0.0),
          landmark + Vector2d(0.0, far_m), landmark - Vector2d(0.0, far_m)};
}

/// Steps to the best of four neighbours, halving the step where none is better. Of cells without
/// information, the one with more landmarks in view is better. Nothing if the evaluations ran out.
std::optional<Cell> ExplorationPoints::climb(LevelCells& cells, const Vector2d& start) const {
  const LevelLattice& lattice = cells.lattice();
  const auto heightOf = [&cells](const Cell& cell) {
    if (!cells.holds(cell)) cells.settle(cell, LevelCells::kVehicle);
    return std::pair{cells.certificate(cell).value, cells.certificate(cell).landmarks};
  };
  Cell best = lattice.cellAt(start);
  auto height = heightOf(best);
  int step = std::max(1, static_cast<int>(0.5 * range_m_ / lattice.resolution_m()));
  while (step >= 1 && cells.levelOf(height.first) < lattice.levels()) {
    Cell better = best;
    for (const Cell& direction : LevelLattice::kNeighbours) {
      if (!cells.mayEvaluate()) return std::nullopt;
      const Cell cell{best.x + step * direction.x, best.y + step * direction.y};
      const auto here = heightOf(cell);
      if (here > height) {
        height = here;
        better = cell;
      }
    }
    if (better == best) step /= 2;
    best = better;
  }
  return best;
}

}  // namespace hymm::core
