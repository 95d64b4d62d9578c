#include "simulation/world_builder.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {
namespace {

constexpr double kBucket_m = 5.0;
constexpr double kPersonRadius_m = 0.2;
constexpr Material kCarPaint{0.2, false, 0.0};
constexpr Material kClothes{0.3, false, 0.01};

Eigen::AlignedBox2d grown(const Eigen::AlignedBox2d& box, double by_m) {
  return {box.min() - Eigen::Vector2d::Constant(by_m), box.max() + Eigen::Vector2d::Constant(by_m)};
}

std::int64_t bucketKey(std::int64_t x, std::int64_t y) {
  const auto high = static_cast<std::uint64_t>(x) << 32;
  return static_cast<std::int64_t>(high ^ (static_cast<std::uint64_t>(y) & 0xffffffff));
}

std::int64_t bucketIndex(double coordinate_m) {
  return static_cast<std::int64_t>(std::floor(coordinate_m / kBucket_m));
}

/// Discs that cover a body that is longer than wide, in its own frame.
std::vector<Disc> coveringDiscs(const Eigen::AlignedBox2d& body) {
  const Eigen::Vector2d size = body.sizes();
  const auto count = std::max(1, static_cast<int>(std::ceil(size.x() / (0.6 * size.y()))));
  const double pitch = size.x() / count;
  std::vector<Disc> discs;
  for (int i = 0; i < count; ++i) {
    discs.push_back({{body.min().x() + (i + 0.5) * pitch, body.center().y()},
                     std::hypot(pitch, size.y()) / 2.0});
  }
  return discs;
}

/// Smallest distance between a disc and a shape, up to rounding; negative if they overlap.
double gapBetween(const Disc& disc, const Shape& shape) {
  return distanceBetween(disc.centre, shape) - disc.radius_m;
}

/// Points of the outline, close enough together to stand for the shape.
std::vector<Eigen::Vector2d> outline(const Shape& shape) {
  if (const auto* disc = std::get_if<Disc>(&shape)) return {disc->centre};
  std::vector<Eigen::Vector2d> points;
  const auto& corners = std::get<Polygon>(shape).corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d edge = corners[(i + 1) % corners.size()] - corners[i];
    const int pieces = 1 + static_cast<int>(edge.norm() / 0.5);
    for (int k = 0; k < pieces; ++k) points.push_back(corners[i] + edge * k / pieces);
  }
  return points;
}

}  // namespace

void WorldBuilder::Buckets::add(const Eigen::AlignedBox2d& bounds, std::size_t index) {
  for (auto x = bucketIndex(bounds.min().x()); x <= bucketIndex(bounds.max().x()); ++x) {
    for (auto y = bucketIndex(bounds.min().y()); y <= bucketIndex(bounds.max().y()); ++y) {
      cells_[bucketKey(x, y)].push_back(index);
    }
  }
}

template <class Visitor>
bool WorldBuilder::Buckets::any(const Eigen::AlignedBox2d& bounds, Visitor visit) const {
  for (auto x = bucketIndex(bounds.min().x()); x <= bucketIndex(bounds.max().x()); ++x) {
    for (auto y = bucketIndex(bounds.min().y()); y <= bucketIndex(bounds.max().y()); ++y) {
      const auto cell = cells_.find(bucketKey(x, y));
      if (cell == cells_.end()) continue;
      for (const std::size_t index : cell->second) {
        if (visit(index)) return true;
      }
    }
  }
  return false;
}

WorldBuilder::WorldBuilder(Route route, double speed_mps, const VehicleConfig& vehicle) {
  world_.speed_mps = speed_mps;
  world_.route = std::move(route);
  const double front = vehicle.length_m - vehicle.rear_overhang_m, half = vehicle.width_m / 2.0;
  keepClear(world_.route, {{{front, -half},
                            {front, half},
                            {-vehicle.rear_overhang_m, half},
                            {-vehicle.rear_overhang_m, -half}}});
  const auto& points = world_.route.points();
  for (std::size_t i = 0; i < points.size(); ++i) {
    route_buckets_.add(Eigen::AlignedBox2d(points[i]), i);
  }
}

void WorldBuilder::keepClear(const Route& route, const Polygon& body) {
  constexpr double kPitch_m = 0.5;
  const std::vector<Disc> discs = coveringDiscs(boundsOf(body));
  for (double s = 0.0; s < route.length_m(); s += kPitch_m) {
    const Pose2 pose = route.at(s);
    for (const Disc& disc : discs) {
      clear_.push_back({pose * disc.centre, disc.radius_m + kMargin_m});
      clear_buckets_.add(boundsOf(clear_.back()), clear_.size() - 1);
    }
  }
}

bool WorldBuilder::isFree(const Shape& shape, double spacing_m) const {
  const Eigen::AlignedBox2d bounds = boundsOf(shape);
  const bool in_the_way =
      clear_buckets_.any(bounds, [&](std::size_t i) { return gapBetween(clear_[i], shape) < 0.0; });
  if (in_the_way) return false;
  const auto* disc = std::get_if<Disc>(&shape);
  const double spacing = spacing_m + (disc != nullptr ? disc->radius_m : 0.0);
  const std::vector<Eigen::Vector2d> points = outline(shape);
  return !solid_buckets_.any(grown(bounds, spacing_m), [&](std::size_t i) {
    const Shape& other = world_.solids[i].shape;
    return std::any_of(points.begin(), points.end(), [&](const Eigen::Vector2d& point) {
      return distanceBetween(point, other) < spacing;
    });
  });
}

bool WorldBuilder::tryAdd(const Shape& shape, const Material& material, double spacing_m) {
  if (!isFree(shape, spacing_m)) return false;
  world_.solids.push_back({shape, material, -1});
  solid_buckets_.add(boundsOf(shape), world_.solids.size() - 1);
  return true;
}

bool WorldBuilder::tryAddLandmark(LandmarkType type, const Eigen::Vector2d& position,
                                  double diameter_m, double spacing_m) {
  const bool reflector = type == LandmarkType::kReflector;
  const Material material{reflector ? 0.9 : 0.3, reflector, 0.0};
  if (!tryAdd(Disc{position, diameter_m / 2.0}, material, spacing_m)) return false;
  const int id = static_cast<int>(world_.landmarks.size());
  world_.solids.back().landmark = id;
  world_.landmarks.push_back({id, type, position, diameter_m});
  return true;
}

void WorldBuilder::addMovingCar(const Route& path, double speed_mps, double start_m) {
  const Polygon body = makeBox({}, 4.4, 1.8, 0.3);
  keepClear(path, body);
  world_.movers.push_back({path, speed_mps, start_m, body, kCarPaint});
}

bool WorldBuilder::tryAddPerson(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                                double speed_mps) {
  const Polygon way = makeWall(from, to, 2.0 * kPersonRadius_m);
  if (!isFree(way, kPersonRadius_m)) return false;
  for (const Solid& solid : world_.solids) {
    for (const Eigen::Vector2d& point : outline(solid.shape)) {
      const auto* disc = std::get_if<Disc>(&solid.shape);
      if (distanceBetween(point, way) < (disc != nullptr ? disc->radius_m : 0.0)) return false;
    }
  }
  world_.movers.push_back({Route({from, to}), speed_mps, 0.0,
                           Disc{Eigen::Vector2d::Zero(), kPersonRadius_m}, kClothes});
  return true;
}

double WorldBuilder::distanceFromRoute(const Eigen::Vector2d& point, double limit_m) const {
  double nearest = limit_m;
  route_buckets_.any(grown(Eigen::AlignedBox2d(point), limit_m), [&](std::size_t i) {
    nearest = std::min(nearest, (world_.route.points()[i] - point).norm());
    return false;
  });
  return nearest;
}

}  // namespace hymm::core
