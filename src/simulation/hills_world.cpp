#include <cmath>

#include "common/error.h"
#include "simulation/winding_track.h"
#include "simulation/world_catalog.h"

namespace hymm::core {
namespace {

constexpr double kLapLength_m = 400.0;
constexpr double kReach_m = 35.0;  // trees stand up to here beside the track
constexpr double kSpeed_mps = 3.0;
constexpr int kTrunks = 180;
constexpr int kHills = 14;
constexpr double kSteepest = 0.12;  // that the vehicle drives: 7 degrees

/// Hills and hollows, as high as makes the steepest place of the route `kSteepest`.
Terrain hillyGround(const Route& route, int count, const Roadside& roadside,
                    const WorldBuilder& builder, RandomGenerator& generator) {
  std::vector<Terrain::Hill> hills;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d centre = roadside.sample(builder, generator);
    const double height = sampleUniform(generator, 1.0, 3.0) * (i % 2 == 0 ? 1.0 : -1.0);
    hills.push_back({centre, height, sampleUniform(generator, 12.0, 25.0)});
  }
  const Terrain drawn(hills, route.at(0.0).position());
  double steepest = 0.0;
  for (const Eigen::Vector2d& point : route.points()) {
    steepest = std::max(steepest, drawn.slope(point).norm());
  }
  for (Terrain::Hill& hill : hills) hill.height_m *= kSteepest / steepest;
  return {hills, route.at(0.0).position()};
}

}  // namespace

World makeHills(const WorldConfig& config, const VehicleConfig& vehicle,
                RandomGenerator& generator) {
  const double length = config.lap_length_m > 0.0 ? config.lap_length_m : kLapLength_m;
  const double share = length / kLapLength_m;
  WorldBuilder builder(windingTrack(length, generator), kSpeed_mps, vehicle);
  const Roadside roadside(builder.route(), kReach_m);
  const int hills = std::max(2, static_cast<int>(std::lround(kHills * share)));
  builder.setTerrain(hillyGround(builder.route(), hills, roadside, builder, generator));
  const int trunks =
      config.landmarks > 0 ? config.landmarks : static_cast<int>(std::lround(kTrunks * share));
  const int added = repeatWhileRoom(trunks, [&] {
    const Eigen::Vector2d place = roadside.sample(builder, generator);
    const double diameter = sampleUniform(generator, 0.15, 0.6);
    return builder.tryAddLandmark(LandmarkType::kTrunk, place, diameter, 1.5);
  });
  if (added == trunks) return builder.take();
  throw ConfigError({"simulation: world 'hills' has room for " + std::to_string(added) + " of " +
                     std::to_string(trunks) +
                     " landmarks; ask for fewer or a greater lap_length_m."});
}

}  // namespace hymm::core
