#pragma once

#include "common/random.h"
#include "simulation/world_builder.h"

namespace hymm::core {

/// A closed winding track: a circle with a few waves around it.
Route windingTrack(double length_m, RandomGenerator& generator);

/// The strip along both sides of a track.
class Roadside {
 public:
  Roadside(const Route& route, double reach_m);

  /// A place evenly drawn out of the strip.
  Eigen::Vector2d sample(const WorldBuilder& builder, RandomGenerator& generator) const;

 private:
  Eigen::AlignedBox2d bounds_;
  double reach_m_;
};

/// Calls `tryOnce` until it has succeeded `count` times, or there seems to be no room. Returns how
/// often it has.
template <class TryOnce>
int repeatWhileRoom(int count, TryOnce tryOnce) {
  constexpr int kTriesEach = 1000;
  int done = 0;
  for (int tries = 0; done < count && tries < count * kTriesEach; ++tries) {
    if (tryOnce()) ++done;
  }
  return done;
}

}  // namespace hymm::core
