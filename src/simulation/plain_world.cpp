#include <algorithm>
#include <cmath>

#include "common/error.h"
#include "simulation/world_builder.h"
#include "simulation/world_catalog.h"

namespace hymm::core {
namespace {

constexpr double kAreaEach_m2 = 100.0;
constexpr int kLandmarks = 300;
constexpr int kFewest = 20;             // room for two tracks and the turns between them
constexpr double kTrackPitch_m = 40.0;  // every trunk comes within 20 m or so
constexpr double kTurnRadius_m = 8.0;
constexpr double kSpacing_m = 1.5;
constexpr double kSpeed_mps = 5.0;

/// Parallel tracks over a square, and back along its left side.
Route coveringTracks(double side_m) {
  const int tracks = 2 * std::max(1, static_cast<int>(std::lround(side_m / kTrackPitch_m / 2.0)));
  const double pitch = side_m / tracks;
  const double margin = std::min(pitch / 2.0, 15.0);
  const double left = margin, right = side_m - margin;
  const double inner = left + std::min(pitch, (right - left) / 2.0);
  std::vector<Eigen::Vector2d> corners;
  for (int i = 0; i < tracks; ++i) {
    const double y = (i + 0.5) * pitch;
    const double start = i == 0 ? left : inner, end = i == tracks - 1 ? left : inner;
    if (i % 2 == 0) {
      corners.emplace_back(start, y);
      if (i == 0) corners.emplace_back((left + right) / 2.0, y);
      corners.emplace_back(right, y);
    } else {
      corners.emplace_back(right, y);
      corners.emplace_back(end, y);
    }
  }
  std::rotate(corners.begin(), corners.begin() + 1, corners.end());  // start on the straight
  return Route::rounded(corners, std::min(kTurnRadius_m, pitch / 2.0 - 1.0));
}

}  // namespace

World makePlain(const WorldConfig& config, const VehicleConfig& vehicle,
                RandomGenerator& generator) {
  const int count = config.landmarks > 0 ? config.landmarks : kLandmarks;
  if (count < kFewest) {
    throw ConfigError({"simulation: world 'plain' needs at least " + std::to_string(kFewest) +
                       " landmarks, else there is no room to drive."});
  }
  const double side = std::sqrt(kAreaEach_m2 * count);
  WorldBuilder builder(coveringTracks(side), kSpeed_mps, vehicle);
  while (builder.landmarkCount() < static_cast<std::size_t>(count)) {
    const Eigen::Vector2d place(sampleUniform(generator, 0.0, side),
                                sampleUniform(generator, 0.0, side));
    builder.tryAddLandmark(LandmarkType::kTrunk, place, sampleUniform(generator, 0.15, 0.6),
                           kSpacing_m);
  }
  return builder.take();
}

}  // namespace hymm::core
