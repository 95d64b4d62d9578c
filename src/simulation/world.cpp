#include "simulation/world.h"

namespace hymm::core {

World World::transformed(const Pose2& T_parent_world) const {
  World moved = *this;
  moved.route = route.transformed(T_parent_world);
  for (Solid& solid : moved.solids) {
    solid.shape = core::transformed(T_parent_world, solid.shape);
  }
  for (Mover& mover : moved.movers) mover.path = mover.path.transformed(T_parent_world);
  for (TrueLandmark& landmark : moved.landmarks) {
    landmark.position = T_parent_world * landmark.position;
  }
  moved.terrain = terrain.transformed(T_parent_world);
  return moved;
}

}  // namespace hymm::core
