#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "door_planner/cell_costs.h"
#include "door_planner/ltr_view.h"

namespace hymm::core {

/// A side of the mesh by the ids of its landmarks, the smaller first. Places on it run from the
/// first (0) to the second (1).
using SideKey = std::pair<int, int>;

SideKey sideKeyOf(const LtrView& ltr, int side);
/// Which side of the LTR it is; kNone if none.
int findSide(const LtrView& ltr, const SideKey& key);

/// Local coordinates of a place on side `side` of an LTR.
Triangle::Local placeOnSide(const LtrView& ltr, int side, double at);

/// A stretch of a side that the vehicle's centre can cross.
struct Door {
  std::uint64_t id = 0;  ///< stays the same while the door changes its borders only
  double from = 0.0, to = 0.0;
  std::size_t first_portal = 0, portals = 0;

  bool operator==(const Door& o) const {
    return id == o.id && from == o.from && to == o.to && first_portal == o.first_portal &&
           portals == o.portals;
  }
};

/// The doors of one side and the portals, points that both LTRs share, that they are split into.
struct SideDoors {
  std::vector<Door> doors;
  std::vector<double> portals;  ///< ascending

  bool operator==(const SideDoors& o) const { return doors == o.doors && portals == o.portals; }
  bool samePlaces(const SideDoors& other) const { return portals == other.portals; }
};

/// What a side is like on one of its two LTRs.
struct SideView {
  const LtrView& ltr;
  int side;
  const CellCosts& costs;
};

/// Doors are where a side is passable in the cells of both LTRs, and free over at least the
/// vehicle's width times the larger K of the two. Portals are at most `spacing_m`, and a quarter of
/// the side, apart. `solid`: stretches of the side that are not free, whatever the cells hold.
/// Doors without an id (0) are new: see keepIds().
SideDoors findDoors(const SideView& one, const SideView& other,
                    const std::vector<std::pair<double, double>>& solid, double vehicle_width_m,
                    double spacing_m);

/// Gives doors the ids of those that they overlap most with, and new ones from `next_id` on.
void keepIds(const SideDoors& before, SideDoors& doors, std::uint64_t& next_id);

}  // namespace hymm::core
