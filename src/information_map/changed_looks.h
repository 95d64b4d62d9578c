#pragma once

#include <vector>

#include <Eigen/Core>

#include "information_map/level_cells.h"

namespace hymm::core {

/// Cells from which changes of the dense map may have hidden or revealed a landmark: those whose
/// line of sight to one within range passes a changed place. They are all evaluated again, since
/// shadows are too thin for borders and samples to tell of.
class ChangedLooks {
 public:
  explicit ChangedLooks(double range_m) : range_m_(range_m) {}

  /// Squares of half diagonal `half_m` around `places` block a look now and did not, or the other
  /// way round; `clearance_m` from a landmark nothing hides it.
  void note(const std::vector<Eigen::Vector2d>& places, double half_m, double clearance_m);

  bool isDone() const { return noted_.empty() && waiting_.empty(); }

  /// Settles the cells concerned, as far as evaluations go; the rest waits for the next time.
  void settle(LevelCells& cells);

 private:
  struct Changed {
    Eigen::Vector2d place;
    double half_m, clearance_m;
  };
  void appendCells(const Changed& changed, const Eigen::Vector2d& landmark,
                   const LevelLattice& lattice);

  double range_m_;
  std::vector<Changed> noted_;
  std::vector<Cell> waiting_;
};

}  // namespace hymm::core
