#include <algorithm>
#include <cmath>

#include "common/error.h"
#include "simulation/world_builder.h"
#include "simulation/world_catalog.h"

namespace hymm::core {
namespace {

// The layout, in metres: four bands of parked cars along x, three aisles between them, lanes on the
// left, the right and at the top. Traffic keeps to the right.
constexpr double kRight = 80.0;  // parked cars stand from x = 0 to here
constexpr double kTop = 51.0;    // and from y = 0 to here
constexpr double kAisle1 = 8.5, kAisle2 = 25.5, kAisle3 = 42.5, kTopLane = 55.0;
constexpr double kLeftLane = -4.5, kRightLane = kRight + 4.5;
constexpr double kLane = 1.8;  // a lane's centre from the aisle's
constexpr double kStallWidth = 2.6, kStallDepth = 5.0;
constexpr double kShareTaken = 0.7;  // of the stalls
constexpr double kCornerRadius = 5.5;

constexpr double kSpeed_mps = 4.0;
constexpr int kLandmarks = 90;
constexpr int kMovingCars = 3;
constexpr int kPeople = 6;
constexpr double kReflector_m = 0.06;  // diameters
constexpr double kPole_m = 0.2;
constexpr double kSpacing_m = 0.3;
constexpr Material kPaint{0.2, false, 0.0};
constexpr Material kConcrete{0.4, false, 0.0};

/// East along aisle 1, west along aisle 2, east along aisle 3, back along the top and the left.
Route vehiclesRoute() {
  const double outer_left = kLeftLane - 9.0;
  const std::vector<Eigen::Vector2d> corners = {{30.0, kAisle1 - kLane},
                                                {kRightLane + kLane, kAisle1 - kLane},
                                                {kRightLane + kLane, kAisle2 + kLane},
                                                {kLeftLane + kLane, kAisle2 + kLane},
                                                {kLeftLane + kLane, kAisle3 - kLane},
                                                {kRightLane + kLane, kAisle3 - kLane},
                                                {kRightLane + kLane, kTopLane + kLane},
                                                {outer_left, kTopLane + kLane},
                                                {outer_left, kAisle1 - kLane}};
  return Route::rounded(corners, kCornerRadius);
}

/// Clockwise around the band between aisles 1 and 2: always on the other side of the lane.
Route othersRoute() {
  const std::vector<Eigen::Vector2d> corners = {{kRightLane - kLane, kAisle1 + kLane},
                                                {kLeftLane + kLane, kAisle1 + kLane},
                                                {kLeftLane + kLane, kAisle2 - kLane},
                                                {kRightLane - kLane, kAisle2 - kLane}};
  return Route::rounded(corners, kCornerRadius);
}

void addWalls(WorldBuilder& builder) {
  const auto wall = [&](double x0, double y0, double x1, double y1) {
    builder.tryAdd(makeWall({x0, y0}, {x1, y1}, 0.3), kConcrete, 0.0);
  };
  wall(8.0, 62.0, 62.0, 62.0);  // a building's face
  wall(62.0, 62.3, 62.0, 70.0);
  wall(-20.0, 10.0, -20.0, 34.0);
  wall(95.0, -2.0, 95.0, 16.0);
  wall(95.0, 34.0, 95.0, 52.0);
  wall(14.0, -2.0, 40.0, -2.0);  // behind the first row
}

/// A row of stalls whose cars stand across x, their middles at `y`.
void addParkedRow(WorldBuilder& builder, double y, RandomGenerator& generator) {
  for (double x = kStallWidth / 2.0; x < kRight; x += kStallWidth) {
    const bool taken = sampleUniform(generator, 0.0, 1.0) < kShareTaken;
    const double heading = sampleUniform(generator, 0.0, 1.0) < 0.5 ? kPi / 2.0 : -kPi / 2.0;
    const Pose2 pose{x + sampleNormal(generator, 0.1), y + sampleNormal(generator, 0.15),
                     heading + sampleNormal(generator, 0.03)};
    const double length = sampleUniform(generator, 3.8, 4.6);
    const double width = sampleUniform(generator, 1.65, 1.85);
    if (taken) builder.tryAdd(makeBox(pose, length, width, 0.25), kPaint, 0.2);
  }
}

/// Light poles between the bands' two rows and along the top.
void addLightPoles(WorldBuilder& builder) {
  for (const double y : {17.0, 34.0, kTop + 0.5}) {
    for (double x = 13.0; x < kRight; x += 4.0 * kStallWidth) {
      builder.tryAddLandmark(LandmarkType::kTrunk, {x, y}, kPole_m, 0.1);
    }
  }
}

/// A place beside the route, a few metres to its left or right.
Eigen::Vector2d besideRoute(const Route& route, double along_m, RandomGenerator& generator) {
  const double side = sampleUniform(generator, 0.0, 1.0) < 0.5 ? -1.0 : 1.0;
  return route.at(along_m) * Eigen::Vector2d(0.0, side * sampleUniform(generator, 1.5, 6.0));
}

/// Reflector posts along the whole route: at the edge of the lanes and between the cars.
void addReflectors(WorldBuilder& builder, int count, RandomGenerator& generator) {
  constexpr int kTries = 200;
  const double length = builder.route().length_m();
  for (int i = 0; i < count; ++i) {
    bool added = false;
    for (int tries = 0; tries < 2 * kTries && !added; ++tries) {
      // Each in its own stretch of the route; anywhere if there is no room in that.
      const double share = tries < kTries ? (i + sampleUniform(generator, 0.0, 1.0)) / count
                                          : sampleUniform(generator, 0.0, 1.0);
      added = builder.tryAddLandmark(LandmarkType::kReflector,
                                     besideRoute(builder.route(), share * length, generator),
                                     kReflector_m, kSpacing_m);
    }
    if (added) continue;
    throw ConfigError({"simulation: world 'car_park' has room for " +
                       std::to_string(builder.landmarkCount()) +
                       " landmarks, not more; ask for fewer."});
  }
}

void addPeople(WorldBuilder& builder, int count, RandomGenerator& generator) {
  int added = 0;
  for (int tries = 0; added < count && tries < 5000 * (count + 1); ++tries) {
    const Eigen::Vector2d from(sampleUniform(generator, -18.0, 93.0),
                               sampleUniform(generator, -1.0, 61.0));
    const double yaw = sampleUniform(generator, -kPi, kPi);
    const Eigen::Vector2d along(std::cos(yaw), std::sin(yaw));
    const Eigen::Vector2d to = from + sampleUniform(generator, 4.0, 12.0) * along;
    if (builder.tryAddPerson(from, to, sampleUniform(generator, 0.8, 1.6))) ++added;
  }
}

}  // namespace

World makeCarPark(const WorldConfig& config, const VehicleConfig& vehicle,
                  RandomGenerator& generator) {
  WorldBuilder builder(vehiclesRoute(), kSpeed_mps, vehicle);
  const Route others = othersRoute();
  const int cars = config.moving_cars >= 0 ? config.moving_cars : kMovingCars;
  for (int i = 0; i < cars; ++i) {
    builder.addMovingCar(others, kSpeed_mps, others.length_m() * i / cars);
  }
  addWalls(builder);
  addLightPoles(builder);
  for (const double band : {0.0, 12.0, 17.0, 29.0, 34.0, 46.0}) {
    addParkedRow(builder, band + kStallDepth / 2.0, generator);
  }
  const int poles = static_cast<int>(builder.landmarkCount());
  const int count = config.landmarks > 0 ? config.landmarks : kLandmarks;
  addReflectors(builder, std::max(0, count - poles), generator);
  addPeople(builder, config.people >= 0 ? config.people : kPeople, generator);
  return builder.take();
}

}  // namespace hymm::core
