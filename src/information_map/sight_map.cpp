#include "information_map/sight_map.h"

#include <cmath>
#include <limits>

namespace hymm::core {
namespace {

using Eigen::Array2d;
using Eigen::Vector2d;
using Eigen::Vector2i;

/// Calls `visit(cell)` for the cells along a line, from its beginning, until it returns true. Says
/// whether it did. Lengths are in cells.
template <class Visitor>
bool anyAlong(const Vector2d& from, const Vector2d& to, Visitor&& visit) {
  const Vector2d along = to - from;
  Vector2i cell = from.array().floor().cast<int>();
  const Vector2i last = to.array().floor().cast<int>();
  Vector2i step;
  Array2d next, every;  // where on the line the next and each further border is crossed, 0 to 1
  for (int k = 0; k < 2; ++k) {
    step[k] = along[k] > 0.0 ? 1 : -1;
    const double border = cell[k] + (along[k] > 0.0 ? 1.0 : 0.0);
    const bool crosses = along[k] != 0.0;
    next[k] = crosses ? (border - from[k]) / along[k] : std::numeric_limits<double>::infinity();
    every[k] = crosses ? std::abs(1.0 / along[k]) : std::numeric_limits<double>::infinity();
  }
  const int crossings = (last - cell).cwiseAbs().sum();
  for (int i = 0; i <= crossings; ++i) {
    if (visit(cell)) return true;
    const int k = next.x() < next.y() ? 0 : 1;
    cell[k] += step[k];
    next[k] += every[k];
  }
  return false;
}

/// Whether a place's cell can be counted at all; an image ends long before.
bool isCountable(const Vector2d& place, double resolution_m) {
  constexpr double kMostCells = 1e9;
  return place.cwiseAbs().maxCoeff() < kMostCells * resolution_m;
}

}  // namespace

void DenseMapConfig::describe(ConfigSchema& schema) {
  schema.flag("occlusion", occlusion,
              "whether what is occupied in the dense map (hymm_grid) hides landmarks behind it");
  schema.number("occupied_probability", occupied_probability, Range::between(0.05, 0.99),
                "from which a cell of the dense map is occupied");
  schema.number("landmark_clearance_m", landmark_clearance_m, Range::notNegative(),
                "what is nearer to a landmark is the landmark itself, and hides nothing");
  schema.flag("unknown_is_free", unknown_is_free,
              "whether ways to suggested goals may lead where the dense map knows nothing");
}

SightMap::SightMap(const DenseMapConfig& config, const OccupancyImage& image)
    : config_(config),
      resolution_m_(image.resolution_m),
      corner_(image.corner),
      width_(image.width),
      height_(image.height) {
  const double threshold = 100.0 * config.occupied_probability;
  states_.reserve(image.cells.size());
  for (const std::int8_t percent : image.cells) {
    states_.push_back(percent < 0            ? State::kUnknown
                      : percent >= threshold ? State::kOccupied
                                             : State::kFree);
  }
}

bool SightMap::hides(const Vector2d& sensor, const Vector2d& landmark) const {
  const Vector2d look = landmark - sensor;
  const double length_m = look.norm() - config_.landmark_clearance_m;
  if (length_m <= 0.0 || !isCountable(sensor, resolution_m_) ||
      !isCountable(landmark, resolution_m_)) {
    return false;
  }
  const Vector2d end = sensor + look.normalized() * length_m;
  return anyAlong(sensor / resolution_m_, end / resolution_m_,
                  [this](const Vector2i& cell) { return at(cell) == State::kOccupied; });
}

bool SightMap::isFree(const Vector2d& place, double clearance_m) const {
  if (!isCountable(place, resolution_m_)) return config_.unknown_is_free;
  const double reach = clearance_m / resolution_m_;  // in cells
  const int most = static_cast<int>(reach);
  const Vector2i middle = cellAt(place);
  for (int y = -most; y <= most; ++y) {
    for (int x = -most; x <= most; ++x) {
      if (x * x + y * y > reach * reach) continue;
      const State state = at(middle + Vector2i(x, y));
      if (state == State::kOccupied) return false;
      if (state == State::kUnknown && !config_.unknown_is_free) return false;
    }
  }
  return true;
}

std::vector<Vector2d> SightMap::occupiedUnlike(const SightMap* other) const {
  if (other != nullptr && other->resolution_m_ != resolution_m_) other = nullptr;
  std::vector<Vector2d> places;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const Vector2i cell = corner_ + Vector2i(x, y);
      if (at(cell) != State::kOccupied) continue;
      if (other != nullptr && other->at(cell) == State::kOccupied) continue;
      places.emplace_back(resolution_m_ * (cell.cast<double>() + Vector2d::Constant(0.5)));
    }
  }
  return places;
}

SightMap::State SightMap::at(const Vector2i& cell) const {
  const Vector2i inside = cell - corner_;
  if ((inside.array() < 0).any() || inside.x() >= width_ || inside.y() >= height_) {
    return State::kUnknown;
  }
  return states_[std::size_t(inside.y()) * std::size_t(width_) + std::size_t(inside.x())];
}

Vector2i SightMap::cellAt(const Vector2d& place) const {
  return (place / resolution_m_).array().floor().cast<int>();
}

}  // namespace hymm::core
