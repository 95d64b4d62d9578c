#include "information_map/changed_looks.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {
namespace {

using Eigen::Vector2d;

double distanceToSegment(const Vector2d& point, const Vector2d& from, const Vector2d& to) {
  const Vector2d along = to - from;
  const double squared = along.squaredNorm();
  const double share =
      squared > 0.0 ? std::clamp((point - from).dot(along) / squared, 0.0, 1.0) : 0.0;
  return (from + share * along - point).norm();
}

}  // namespace

void ChangedLooks::note(const std::vector<Vector2d>& places, double half_m, double clearance_m) {
  for (const Vector2d& place : places) noted_.push_back({place, half_m, clearance_m});
}

void ChangedLooks::settle(LevelCells& cells) {
  for (const Changed& changed : noted_) {
    cells.field().visitNear(changed.place, range_m_, [&](int landmark) {
      appendCells(changed, cells.field().position(landmark), cells.lattice());
    });
  }
  noted_.clear();
  std::sort(waiting_.begin(), waiting_.end(),
            [](const Cell& a, const Cell& b) { return a.y != b.y ? a.y < b.y : a.x < b.x; });
  waiting_.erase(std::unique(waiting_.begin(), waiting_.end()), waiting_.end());
  for (const Cell& cell : waiting_) cells.revoke(cell);
  while (!waiting_.empty() && cells.mayEvaluate()) {
    if (!cells.holds(waiting_.back())) cells.settle(waiting_.back(), LevelCells::kOthers);
    waiting_.pop_back();
  }
}

/// The cells behind the changed square, as seen from a landmark: walks the wedge that it subtends
/// in half cells.
void ChangedLooks::appendCells(const Changed& changed, const Vector2d& landmark,
                               const LevelLattice& lattice) {
  const Vector2d offset = changed.place - landmark;
  const double distance_m = offset.norm(), half_m = changed.half_m;
  if (distance_m + half_m < changed.clearance_m || distance_m <= half_m) return;
  const double step_m = 0.5 * lattice.resolution_m();
  const Vector2d along = offset / distance_m, across(-along.y(), along.x());
  const double slope = half_m / std::sqrt(distance_m * distance_m - half_m * half_m);
  for (double r = distance_m - half_m; r < range_m_ + step_m; r += step_m) {
    const double reach_m = slope * r + step_m;
    for (double s = -reach_m; s < reach_m + step_m; s += step_m) {
      const Cell cell = lattice.cellAt(landmark + r * along + s * across);
      if (!waiting_.empty() && waiting_.back() == cell) continue;
      const Vector2d centre = lattice.centre(cell);
      if ((centre - landmark).squaredNorm() > range_m_ * range_m_) continue;
      if (distanceToSegment(changed.place, landmark, centre) <= half_m) waiting_.push_back(cell);
    }
  }
}

}  // namespace hymm::core
