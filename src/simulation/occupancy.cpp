#include "simulation/occupancy.h"

#include <cmath>
#include <stdexcept>

namespace hymm::core {
namespace {

constexpr double kRoom_m = 5.0;

Eigen::AlignedBox2d boundsOfWorld(const World& world) {
  Eigen::AlignedBox2d bounds;
  for (const Eigen::Vector2d& point : world.route.points()) bounds.extend(point);
  for (const Solid& solid : world.solids) bounds.extend(boundsOf(solid.shape));
  return {bounds.min().array() - kRoom_m, bounds.max().array() + kRoom_m};
}

void fill(const Shape& shape, TrueOccupancy& map) {
  const double r = map.resolution_m;
  const Eigen::AlignedBox2d bounds = boundsOf(shape);
  const Eigen::Array2i low = ((bounds.min() - map.origin).array() / r).floor().cast<int>();
  const Eigen::Array2i high = ((bounds.max() - map.origin).array() / r).floor().cast<int>();
  for (int y = low.y(); y <= high.y(); ++y) {
    for (int x = low.x(); x <= high.x(); ++x) {
      const Eigen::Vector2d centre = map.origin + r * Eigen::Vector2d(x + 0.5, y + 0.5);
      if (distanceBetween(centre, shape) > r / 2.0) continue;
      map.occupied[static_cast<std::size_t>(y) * static_cast<std::size_t>(map.width) +
                   static_cast<std::size_t>(x)] = true;
    }
  }
}

}  // namespace

TrueOccupancy rasterised(const World& world, double resolution_m) {
  if (!(resolution_m > 0.0)) throw std::invalid_argument("resolution_m must be positive");
  const Eigen::AlignedBox2d bounds = boundsOfWorld(world);
  TrueOccupancy map;
  map.resolution_m = resolution_m;
  map.origin = (bounds.min().array() / resolution_m).floor() * resolution_m;
  const Eigen::Vector2d size = bounds.max() - map.origin;
  map.width = static_cast<int>(std::ceil(size.x() / resolution_m));
  map.height = static_cast<int>(std::ceil(size.y() / resolution_m));
  map.occupied.assign(static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height),
                      false);
  for (const Solid& solid : world.solids) fill(solid.shape, map);
  return map;
}

}  // namespace hymm::core
