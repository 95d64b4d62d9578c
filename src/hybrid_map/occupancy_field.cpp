#include "hybrid_map/occupancy_field.h"

#include <algorithm>
#include <limits>

#include "hybrid_map/log_odds.h"

namespace hymm::core {
namespace {

// map_server's threshold of what is certainly occupied.
const auto kOccupiedLogOdds = static_cast<float>(logOddsOf(0.65));

}  // namespace

OccupancyField::OccupancyField(const HybridMap& map, const Eigen::Vector2d& centre, double reach_m,
                               double resolution_m)
    : resolution_m_(resolution_m),
      low_(centre.array() - reach_m),
      edge_(static_cast<int>(std::ceil(2.0 * reach_m / resolution_m))) {
  const std::vector<float> log_odds = map.renderOccupancy(low_, edge_, edge_, resolution_m);
  const auto farthest = static_cast<float>(this->farthest());
  distances_.resize(log_odds.size());
  std::transform(log_odds.begin(), log_odds.end(), distances_.begin(), [farthest](float value) {
    return std::isnan(value) ? std::numeric_limits<float>::quiet_NaN() : farthest;
  });
  for (int y = 0; y < edge_; ++y) {
    for (int x = 0; x < edge_; ++x) {
      const float value = log_odds[std::size_t(y) * std::size_t(edge_) + std::size_t(x)];
      if (value > kOccupiedLogOdds) stamp(x, y);
    }
  }
}

/// Lowers the distances around an occupied cell.
void OccupancyField::stamp(int x, int y) {
  has_obstacles_ = true;
  for (int j = std::max(0, y - kFarthestCells); j <= std::min(edge_ - 1, y + kFarthestCells); ++j) {
    for (int i = std::max(0, x - kFarthestCells); i <= std::min(edge_ - 1, x + kFarthestCells);
         ++i) {
      float& distance = distances_[std::size_t(j) * std::size_t(edge_) + std::size_t(i)];
      const double from_here = resolution_m_ * std::hypot(i - x, j - y);
      if (from_here > farthest()) continue;
      if (!(distance <= static_cast<float>(from_here))) distance = static_cast<float>(from_here);
    }
  }
}

float OccupancyField::at(int x, int y) const {
  if (x < 0 || y < 0 || x >= edge_ || y >= edge_) return std::numeric_limits<float>::quiet_NaN();
  return distances_[std::size_t(y) * std::size_t(edge_) + std::size_t(x)];
}

double OccupancyField::smoothDistance(const Eigen::Vector2d& place) const {
  const Eigen::Vector2d cells = (place - low_) / resolution_m_ - Eigen::Vector2d(0.5, 0.5);
  const double x0 = std::floor(cells.x()), y0 = std::floor(cells.y());
  const double u = cells.x() - x0, v = cells.y() - y0;
  const auto known = [&](int dx, int dy) {
    const float distance = at(static_cast<int>(x0) + dx, static_cast<int>(y0) + dy);
    return std::isnan(distance) ? farthest() : static_cast<double>(distance);
  };
  return (1.0 - v) * ((1.0 - u) * known(0, 0) + u * known(1, 0)) +
         v * ((1.0 - u) * known(0, 1) + u * known(1, 1));
}

}  // namespace hymm::core
