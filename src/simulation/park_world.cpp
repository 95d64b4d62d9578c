#include <cmath>

#include "common/error.h"
#include "simulation/winding_track.h"
#include "simulation/world_catalog.h"

namespace hymm::core {
namespace {

constexpr double kLapLength_m = 333.0;  // three laps are 1 km
constexpr double kReach_m = 35.0;       // trees stand up to here beside the track
constexpr double kSpeed_mps = 3.0;
constexpr int kTrunks = 150;
constexpr int kPeople = 8;
constexpr int kBushes = 12;
constexpr int kHedges = 5;
constexpr int kShelters = 4;
constexpr Material kLeaves{0.3, false, 0.08};
constexpr Material kBrick{0.4, false, 0.0};

/// An irregular clump of leaves.
Polygon bush(const Eigen::Vector2d& centre, RandomGenerator& generator) {
  constexpr int kCorners = 11;
  const double size = sampleUniform(generator, 0.8, 2.0);
  Polygon polygon;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2.0 * kPi * i / kCorners;
    const double radius = size * sampleUniform(generator, 0.6, 1.0);
    polygon.corners.emplace_back(centre +
                                 radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return polygon;
}

/// A straight piece of wall or hedge with one end at `from`.
Polygon straightPiece(const Eigen::Vector2d& from, double yaw_rad, double length_m,
                      double thickness_m) {
  const Eigen::Vector2d along(std::cos(yaw_rad), std::sin(yaw_rad));
  return makeWall(from, from + length_m * along, thickness_m);
}

/// A bus stop's two walls, of which the second may find no room.
bool tryAddShelter(WorldBuilder& builder, const Eigen::Vector2d& corner,
                   RandomGenerator& generator) {
  const double yaw = sampleUniform(generator, -kPi, kPi);
  const double length = sampleUniform(generator, 3.0, 7.0);
  if (!builder.tryAdd(straightPiece(corner, yaw, length, 0.15), kBrick, 0.3)) return false;
  const Eigen::Vector2d beside =
      corner + Pose2{0.0, 0.0, yaw}.rotation() * Eigen::Vector2d(0.1, 0.2);
  builder.tryAdd(straightPiece(beside, yaw + kPi / 2.0, 2.5, 0.15), kBrick, 0.02);
  return true;
}

void addTrunks(WorldBuilder& builder, const Roadside& ground, int count,
               RandomGenerator& generator) {
  const int added = repeatWhileRoom(count, [&] {
    const double u = sampleUniform(generator, 0.0, 1.0);
    const double diameter = 0.1 + 0.9 * u * u;  // most trees are young
    return builder.tryAddLandmark(LandmarkType::kTrunk, ground.sample(builder, generator), diameter,
                                  1.5);
  });
  if (added == count) return;
  throw ConfigError({"simulation: world 'park' has room for " + std::to_string(added) + " of " +
                     std::to_string(count) +
                     " landmarks; ask for fewer or a greater lap_length_m."});
}

}  // namespace

World makePark(const WorldConfig& config, const VehicleConfig& vehicle,
               RandomGenerator& generator) {
  const double length = config.lap_length_m > 0.0 ? config.lap_length_m : kLapLength_m;
  WorldBuilder builder(windingTrack(length, generator), kSpeed_mps, vehicle);
  const double share = length / kLapLength_m;
  const auto scaled = [&](int count) { return static_cast<int>(std::lround(count * share)); };
  const Roadside ground(builder.route(), kReach_m);
  repeatWhileRoom(scaled(kShelters), [&] {
    return tryAddShelter(builder, ground.sample(builder, generator), generator);
  });
  repeatWhileRoom(scaled(kHedges), [&] {
    const double yaw = sampleUniform(generator, -kPi, kPi);
    const double hedge = sampleUniform(generator, 4.0, 12.0);
    return builder.tryAdd(straightPiece(ground.sample(builder, generator), yaw, hedge, 1.0),
                          kLeaves, 0.5);
  });
  repeatWhileRoom(scaled(kBushes), [&] {
    return builder.tryAdd(bush(ground.sample(builder, generator), generator), kLeaves, 0.5);
  });
  addTrunks(builder, ground, config.landmarks > 0 ? config.landmarks : scaled(kTrunks), generator);
  repeatWhileRoom(config.people >= 0 ? config.people : scaled(kPeople), [&] {
    const Eigen::Vector2d from = ground.sample(builder, generator);
    const double yaw = sampleUniform(generator, -kPi, kPi);
    const double way = sampleUniform(generator, 6.0, 20.0);
    const Eigen::Vector2d to = from + way * Eigen::Vector2d(std::cos(yaw), std::sin(yaw));
    return builder.tryAddPerson(from, to, sampleUniform(generator, 0.8, 1.6));
  });
  return builder.take();
}

}  // namespace hymm::core
