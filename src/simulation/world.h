#pragma once

#include <vector>

#include "simulation/route.h"
#include "simulation/solid.h"
#include "simulation/terrain.h"
#include "simulation/truth.h"

namespace hymm::core {

/// Something solid that moves along a closed path for ever.
struct Mover {
  Route path;
  double speed_mps = 0.0;
  double start_m = 0.0;  ///< place on the path at time 0
  Shape body;            ///< in its own frame, x forward
  Material material;

  Solid at(double time_s) const {
    return {transformed(path.at(start_m + speed_mps * time_s), body), material, -1};
  }
};

/// Everything that stands and moves, and the route that the vehicle drives.
struct World {
  Route route;
  double speed_mps = 3.0;  ///< that suits the world
  std::vector<Solid> solids;
  std::vector<Mover> movers;
  std::vector<TrueLandmark> landmarks;
  Terrain terrain;  ///< what all of it stands on

  /// The same world in the parent frame.
  World transformed(const Pose2& T_parent_world) const;
};

}  // namespace hymm::core
