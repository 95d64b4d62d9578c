#include <algorithm>
#include <cmath>

#include "common/error.h"
#include "simulation/winding_track.h"
#include "simulation/world_catalog.h"

namespace hymm::core {
namespace {

constexpr int kTrees = 160;
constexpr int kFewest = 12;
constexpr double kSpeed_mps = 2.0;
constexpr double kRowPitch_m = 6.0;
constexpr double kTrackPitch_m =
    2.0 * kRowPitch_m;  // every other alley: the car cannot turn tighter
constexpr double kTurnRadius_m = 5.4;
constexpr double kTreePitch_m = 4.0;
constexpr double kJitter_m = 0.1;
constexpr double kGaps = 0.05;       // share of trees that are missing
constexpr double kHeadland_m = 8.0;  // from where the car turns to the first tree
constexpr double kTrackSpan = 3.0;   // trees of a row for each track, which makes it about square
constexpr int kPeople = 4;
constexpr int kBins = 6;
constexpr double kBin_m = 1.2;
constexpr Material kWood{0.4, false, 0.01};

/// How many rows of how many trees, and where.
struct Layout {
  int tracks, trees;   ///< trees in each row, of which there are two for each track
  double left, right;  ///< of the rows, m

  explicit Layout(int count) {
    const double each = 2.0 * kTrackSpan * (1.0 - kGaps);
    tracks = 2 * std::max(1, static_cast<int>(std::lround(std::sqrt(count / each) / 2.0)));
    trees = static_cast<int>(std::ceil(count / (2.0 * tracks * (1.0 - kGaps))));
    left = kTrackPitch_m + kHeadland_m;
    right = left + kTreePitch_m * (trees - 1);
  }
  double track(int i) const { return kTrackPitch_m * i; }

  /// Along each track, and back along the left side, where no rows are. Begins on a straight.
  Route route() const {
    const double end = right + kHeadland_m, back = 0.0, turn = kTrackPitch_m;
    std::vector<Eigen::Vector2d> corners{{(turn + end) / 2.0, 0.0}};
    for (int i = 0; i < tracks; ++i) {
      const bool goes_right = i % 2 == 0;
      if (i > 0) corners.emplace_back(goes_right ? turn : end, track(i));
      const double to = i == tracks - 1 ? back : turn;
      corners.emplace_back(goes_right ? end : to, track(i));
    }
    corners.emplace_back(back, 0.0);
    return Route::rounded(corners, kTurnRadius_m);
  }
};

/// Places for all trees, gaps not yet left, in random order.
std::vector<Eigen::Vector2d> treePlaces(const Layout& layout, RandomGenerator& generator) {
  std::vector<Eigen::Vector2d> places;
  for (int i = 0; i < layout.tracks; ++i) {
    for (const double side : {-0.5, 0.5}) {
      for (int k = 0; k < layout.trees; ++k) {
        const double x = layout.left + kTreePitch_m * k + sampleNormal(generator, kJitter_m);
        const double y = layout.track(i) + side * kRowPitch_m + sampleNormal(generator, kJitter_m);
        places.emplace_back(x, y);
      }
    }
  }
  std::shuffle(places.begin(), places.end(), generator);
  return places;
}

void plant(WorldBuilder& builder, const Layout& layout, int count, RandomGenerator& generator) {
  int planted = 0;
  for (const Eigen::Vector2d& place : treePlaces(layout, generator)) {
    if (planted == count) return;
    const double diameter = sampleUniform(generator, 0.12, 0.3);
    if (builder.tryAddLandmark(LandmarkType::kTrunk, place, diameter, 1.0)) ++planted;
  }
  if (planted == count) return;
  throw ConfigError({"simulation: world 'orchard' has room for " + std::to_string(planted) +
                     " of " + std::to_string(count) +
                     " trees beside a vehicle of this size; is it wider than an alley?"});
}

/// A place in one of the alleys that the vehicle does not drive.
Eigen::Vector2d inIdleAlley(const Layout& layout, RandomGenerator& generator) {
  const double alley = std::floor(sampleUniform(generator, 0.0, layout.tracks - 1.0));
  const double x = sampleUniform(generator, layout.left, layout.right);
  return {x, kTrackPitch_m * (alley + 0.5) + sampleUniform(generator, -1.5, 1.5)};
}

}  // namespace

World makeOrchard(const WorldConfig& config, const VehicleConfig& vehicle,
                  RandomGenerator& generator) {
  const int count = config.landmarks > 0 ? config.landmarks : kTrees;
  if (count < kFewest) {
    throw ConfigError({"simulation: world 'orchard' needs at least " + std::to_string(kFewest) +
                       " landmarks, else there are no rows."});
  }
  const Layout layout(count);
  WorldBuilder builder(layout.route(), kSpeed_mps, vehicle);
  plant(builder, layout, count, generator);
  repeatWhileRoom(kBins, [&] {
    const Eigen::Vector2d place = inIdleAlley(layout, generator);
    const double yaw = sampleUniform(generator, -kPi, kPi);
    return builder.tryAdd(makeBox({place.x(), place.y(), yaw}, kBin_m, kBin_m), kWood, 0.5);
  });
  repeatWhileRoom(config.people >= 0 ? config.people : kPeople, [&] {
    const Eigen::Vector2d from = inIdleAlley(layout, generator);
    const double way = sampleUniform(generator, 4.0, 12.0);
    const Eigen::Vector2d to(std::min(from.x() + way, layout.right), from.y());
    return to.x() > from.x() + 1.0 &&
           builder.tryAddPerson(from, to, sampleUniform(generator, 0.3, 1.0));
  });
  return builder.take();
}

}  // namespace hymm::core
