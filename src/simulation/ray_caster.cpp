#include "simulation/ray_caster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace hymm::core {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

struct Meeting {
  double range_m, incidence_cosine;
};

std::optional<Meeting> meetDisc(const Disc& disc, const Eigen::Vector2d& origin,
                                const Eigen::Vector2d& direction) {
  const Eigen::Vector2d to_centre = disc.centre - origin;
  const double along = to_centre.dot(direction);
  const double across = cross(direction, to_centre);
  const double half_chord_squared = disc.radius_m * disc.radius_m - across * across;
  if (half_chord_squared < 0.0) return std::nullopt;
  const double half_chord = std::sqrt(half_chord_squared);
  const double range = along > half_chord ? along - half_chord : along + half_chord;
  if (range <= 0.0) return std::nullopt;
  return Meeting{range, half_chord / disc.radius_m};
}

std::optional<Meeting> meetEdge(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                                const Eigen::Vector2d& origin, const Eigen::Vector2d& direction) {
  const Eigen::Vector2d edge = to - from;
  const double sine = cross(direction, edge);
  if (sine == 0.0) return std::nullopt;
  const Eigen::Vector2d to_edge = from - origin;
  const double range = cross(to_edge, edge) / sine;
  const double share = cross(to_edge, direction) / sine;
  if (range <= 0.0 || share < 0.0 || share > 1.0) return std::nullopt;
  return Meeting{range, std::abs(sine) / edge.norm()};
}

/// The stretch of a ray within one slab of the bounds: entry and exit range.
void clip(double origin, double direction, double low, double high, double& entry, double& exit) {
  if (direction == 0.0) {
    if (origin < low || origin > high) exit = -kInfinity;
    return;
  }
  const double a = (low - origin) / direction, b = (high - origin) / direction;
  entry = std::max(entry, std::min(a, b));
  exit = std::min(exit, std::max(a, b));
}

}  // namespace

RayCaster::RayCaster(const std::vector<Solid>& solids, double cell_m) : cell_m_(cell_m) {
  for (std::size_t i = 0; i < solids.size(); ++i) addSurfaces(solids[i], i);
  fillGrid();
}

void RayCaster::addSurfaces(const Solid& solid, std::size_t index) {
  bounds_.extend(boundsOf(solid.shape));
  if (const auto* disc = std::get_if<Disc>(&solid.shape)) {
    surfaces_.push_back({*disc, index});
    return;
  }
  const auto& corners = std::get<Polygon>(solid.shape).corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    surfaces_.push_back({Edge{corners[i], corners[(i + 1) % corners.size()]}, index});
  }
}

void RayCaster::fillGrid() {
  if (surfaces_.empty()) return;
  cells_ = (bounds_.sizes().array() / cell_m_).floor().cast<int>() + 1;
  std::vector<std::vector<std::size_t>> lists(static_cast<std::size_t>(cells_.prod()));
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    Eigen::AlignedBox2d box;
    if (const auto* disc = std::get_if<Disc>(&surfaces_[i].form)) {
      box = boundsOf(*disc);
    } else {
      const auto& edge = std::get<Edge>(surfaces_[i].form);
      box.extend(edge.from).extend(edge.to);
    }
    const Eigen::Array2i low = cellOf(box.min()), high = cellOf(box.max());
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) {
        lists[static_cast<std::size_t>(y * cells_.x() + x)].push_back(i);
      }
    }
  }
  cell_begin_.push_back(0);
  for (const auto& list : lists) {
    cell_surfaces_.insert(cell_surfaces_.end(), list.begin(), list.end());
    cell_begin_.push_back(cell_surfaces_.size());
  }
}

Eigen::Array2i RayCaster::cellOf(const Eigen::Vector2d& point) const {
  const Eigen::Array2i cell = ((point - bounds_.min()).array() / cell_m_).floor().cast<int>();
  return cell.max(0).min(cells_ - 1);
}

void RayCaster::meet(const Surface& surface, const Eigen::Vector2d& origin,
                     const Eigen::Vector2d& direction, std::optional<RayHit>& nearest,
                     double& range_limit_m) const {
  const auto* disc = std::get_if<Disc>(&surface.form);
  const auto* edge = std::get_if<Edge>(&surface.form);
  const auto meeting = disc != nullptr ? meetDisc(*disc, origin, direction)
                                       : meetEdge(edge->from, edge->to, origin, direction);
  if (!meeting || meeting->range_m > range_limit_m) return;
  nearest = RayHit{meeting->range_m, meeting->incidence_cosine, surface.solid};
  range_limit_m = meeting->range_m;
}

std::optional<RayHit> RayCaster::cast(const Eigen::Vector2d& origin,
                                      const Eigen::Vector2d& direction, double range_max_m) const {
  std::optional<RayHit> nearest;
  if (surfaces_.empty()) return nearest;
  double entry = 0.0, exit = range_max_m;
  clip(origin.x(), direction.x(), bounds_.min().x(), bounds_.max().x(), entry, exit);
  clip(origin.y(), direction.y(), bounds_.min().y(), bounds_.max().y(), entry, exit);
  if (entry > exit) return nearest;

  // Walk from cell to cell along the ray until what was met lies before the next cell.
  Eigen::Array2i cell = cellOf(origin + entry * direction);
  std::array<int, 2> step{};
  std::array<double, 2> next{}, pitch{};
  for (int axis = 0; axis < 2; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const double d = direction[axis];
    step[a] = d > 0.0 ? 1 : -1;
    const double border = bounds_.min()[axis] + cell_m_ * (cell[axis] + (d > 0.0 ? 1 : 0));
    next[a] = d == 0.0 ? kInfinity : (border - origin[axis]) / d;
    pitch[a] = d == 0.0 ? kInfinity : cell_m_ / std::abs(d);
  }
  double range_limit = range_max_m;
  while ((cell >= 0).all() && (cell < cells_).all()) {
    const auto index = static_cast<std::size_t>(cell.y() * cells_.x() + cell.x());
    for (std::size_t i = cell_begin_[index]; i < cell_begin_[index + 1]; ++i) {
      meet(surfaces_[cell_surfaces_[i]], origin, direction, nearest, range_limit);
    }
    const std::size_t axis = next[0] < next[1] ? 0 : 1;
    if (next[axis] >= std::min(range_limit, exit)) break;
    cell[static_cast<Eigen::Index>(axis)] += step[axis];
    next[axis] += pitch[axis];
  }
  return nearest;
}

}  // namespace hymm::core
