#include <cmath>

#include "common/error.h"
#include "simulation/world_builder.h"
#include "simulation/world_catalog.h"

namespace hymm::core {
namespace {

constexpr double kLapLength_m = 900.0;
constexpr double kHeight_m = 120.0;
constexpr double kTurnRadius_m = 12.0;
constexpr double kSpeed_mps = 4.0;
constexpr double kRowPitch_m = 5.0;  // less than the vehicle's uncertainty when it comes back
constexpr double kRowJitter_m = 0.1;
constexpr double kRowOffset_m = 6.0;     // of the rows from the track
constexpr double kGapProbability = 0.2;  // what tells a row's parts apart in the end
constexpr double kAvenueStart_m = 15.0;  // so far ahead that the first lap sees all of it
constexpr double kAvenue_m = 120.0;      // rows on either side
constexpr double kReach_m = 25.0;
constexpr double kAreaEach_m2 = 150.0;
constexpr int kTriesEach = 1000;

Route roundTrip(double length_m) {
  const double width = length_m / 2.0 - kHeight_m + 4.0 * kTurnRadius_m * (1.0 - kPi / 4.0);
  if (width / 2.0 < kAvenueStart_m + kAvenue_m + 2.0 * kTurnRadius_m) {
    throw ConfigError(
        {"simulation: world 'loop' needs a lap_length_m of at least " +
         std::to_string(static_cast<int>(2.0 * (kHeight_m + 2.0 * (kAvenueStart_m + kAvenue_m)) +
                                         8.0 * kTurnRadius_m)) +
         "."});
  }
  return Route::rounded({{0.0, 0.0},
                         {width / 2.0, 0.0},
                         {width / 2.0, kHeight_m},
                         {-width / 2.0, kHeight_m},
                         {-width / 2.0, 0.0}},
                        kTurnRadius_m);
}

/// Trees of one size at one pitch, on both sides of the track ahead of where the vehicle starts and
/// comes back.
void addAvenue(WorldBuilder& builder, RandomGenerator& generator) {
  for (double x = kAvenueStart_m; x <= kAvenueStart_m + kAvenue_m; x += kRowPitch_m) {
    for (const double side : {-1.0, 1.0}) {
      if (sampleUniform(generator, 0.0, 1.0) < kGapProbability) continue;
      const Eigen::Vector2d place(x + sampleNormal(generator, kRowJitter_m),
                                  side * kRowOffset_m + sampleNormal(generator, kRowJitter_m));
      builder.tryAddLandmark(LandmarkType::kTrunk, place, 0.3, 1.0);
    }
  }
}

void addScattered(WorldBuilder& builder, int count, RandomGenerator& generator) {
  Eigen::AlignedBox2d bounds;
  for (const Eigen::Vector2d& point : builder.route().points()) bounds.extend(point);
  bounds.extend(bounds.min() - Eigen::Vector2d::Constant(kReach_m));
  bounds.extend(bounds.max() + Eigen::Vector2d::Constant(kReach_m));
  int added = 0;
  for (int tries = 0; added < count && tries < count * kTriesEach; ++tries) {
    const Eigen::Vector2d place(sampleUniform(generator, bounds.min().x(), bounds.max().x()),
                                sampleUniform(generator, bounds.min().y(), bounds.max().y()));
    if (builder.distanceFromRoute(place, kReach_m) >= kReach_m) continue;
    const bool in_avenue = place.x() > kAvenueStart_m - 5.0 &&
                           place.x() < kAvenueStart_m + kAvenue_m + 5.0 &&
                           std::abs(place.y()) < kRowOffset_m + 4.0;
    if (in_avenue) continue;
    if (builder.tryAddLandmark(LandmarkType::kTrunk, place, sampleUniform(generator, 0.2, 0.5),
                               2.0)) {
      ++added;
    }
  }
  if (added == count) return;
  throw ConfigError({"simulation: world 'loop' has room for " + std::to_string(added) + " of " +
                     std::to_string(count) + " scattered landmarks; ask for fewer."});
}

}  // namespace

World makeLoop(const WorldConfig& config, const VehicleConfig& vehicle,
               RandomGenerator& generator) {
  const double length = config.lap_length_m > 0.0 ? config.lap_length_m : kLapLength_m;
  WorldBuilder builder(roundTrip(length), kSpeed_mps, vehicle);
  addAvenue(builder, generator);
  const int scattered = static_cast<int>(2.0 * kReach_m * length / kAreaEach_m2);
  addScattered(builder,
               config.landmarks > 0
                   ? std::max(0, config.landmarks - static_cast<int>(builder.landmarkCount()))
                   : scattered,
               generator);
  return builder.take();
}

}  // namespace hymm::core
