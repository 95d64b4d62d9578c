#include "door_planner/side_doors.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {
namespace {

double shapeFactorOf(const LtrView& ltr) {
  return std::isnan(ltr.shape_factor) ? 1.0 : ltr.shape_factor;
}

double sideLength(const LtrView& ltr, int side) {
  return (ltr.corners[std::size_t((side + 1) % 3)] - ltr.corners[std::size_t(side)]).norm();
}

/// Places along a side, in the middle of equal parts: what is occupied, and what is passable.
struct SideSamples {
  std::vector<bool> free, passable;

  std::size_t count() const { return free.size(); }
  double at(std::size_t sample) const {
    return (static_cast<double>(sample) + 0.5) / static_cast<double>(count());
  }
};

SideSamples sample(const SideView& one, const SideView& other,
                   const std::vector<std::pair<double, double>>& solid) {
  int cells = 1;
  for (const SideView* view : {&one, &other}) {
    cells = std::max({cells, view->costs.grid().alphaCells(), view->costs.grid().betaCells()});
  }
  SideSamples samples;
  const std::size_t count = 2 * std::size_t(cells);
  samples.free.assign(count, true);
  samples.passable.assign(count, true);
  for (const SideView* view : {&one, &other}) {
    if (view->costs.isUniform() && view->costs.isPassable(0)) continue;
    for (std::size_t i = 0; i < count; ++i) {
      const int cell = view->costs.grid().index(placeOnSide(view->ltr, view->side, samples.at(i)));
      if (view->costs.isOccupied(cell)) samples.free[i] = false;
      if (!view->costs.isPassable(cell)) samples.passable[i] = false;
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (const auto& [from, to] : solid) {
      if (from < samples.at(i) && samples.at(i) < to) samples.free[i] = false;
    }
  }
  return samples;
}

/// Runs of set samples within [begin, end), as half-open ranges.
std::vector<std::pair<std::size_t, std::size_t>> runsOf(const std::vector<bool>& set,
                                                        std::size_t begin, std::size_t end) {
  std::vector<std::pair<std::size_t, std::size_t>> runs;
  for (std::size_t i = begin; i < end; ++i) {
    if (!set[i]) continue;
    const std::size_t start = i;
    while (i < end && set[i]) ++i;
    runs.emplace_back(start, i);
  }
  return runs;
}

/// Portals of a door between the centres of its outermost samples. Where it reaches a vertex they
/// start half a spacing away from it: there many sides meet, and portals would nearly coincide.
void placePortals(double length_m, double spacing_m, std::size_t samples, SideDoors& doors,
                  Door& door) {
  const double spacing = spacing_m / length_m;
  const double half_sample = 0.5 / static_cast<double>(samples);
  double from = door.from <= 0.0 ? 0.5 * spacing : door.from + half_sample;
  double to = door.to >= 1.0 ? 1.0 - 0.5 * spacing : door.to - half_sample;
  door.first_portal = doors.portals.size();
  if (to - from < 0.5 * spacing) {
    const double middle =
        std::clamp(0.5 * (from + to), door.from + half_sample, door.to - half_sample);
    doors.portals.push_back(middle);
  } else {
    // Rounding must not make one interval more out of a whole number of them.
    const double intervals = std::max(1.0, std::ceil((to - from) / spacing - 1e-6));
    for (int i = 0; i <= static_cast<int>(intervals); ++i) {
      doors.portals.push_back(from + (to - from) * i / intervals);
    }
  }
  door.portals = doors.portals.size() - door.first_portal;
}

}  // namespace

SideKey sideKeyOf(const LtrView& ltr, int side) {
  const int a = ltr.landmark_ids[std::size_t(side)];
  const int b = ltr.landmark_ids[std::size_t((side + 1) % 3)];
  return {std::min(a, b), std::max(a, b)};
}

int findSide(const LtrView& ltr, const SideKey& key) {
  for (int k = 0; k < 3; ++k) {
    if (sideKeyOf(ltr, k) == key) return k;
  }
  return kNone;
}

Triangle::Local placeOnSide(const LtrView& ltr, int side, double at) {
  const bool runs_along =
      ltr.landmark_ids[std::size_t(side)] < ltr.landmark_ids[std::size_t((side + 1) % 3)];
  const double t = runs_along ? at : 1.0 - at;
  if (side == 0) return {t, 0.0};
  if (side == 1) return {1.0 - t, t};
  return {0.0, 1.0 - t};
}

SideDoors findDoors(const SideView& one, const SideView& other,
                    const std::vector<std::pair<double, double>>& solid, double vehicle_width_m,
                    double spacing_m) {
  const SideSamples samples = sample(one, other, solid);
  const double length_m = sideLength(one.ltr, one.side);
  const double sample_m = length_m / static_cast<double>(samples.count());
  const double needed_m =
      vehicle_width_m * std::max(shapeFactorOf(one.ltr), shapeFactorOf(other.ltr));
  const double spacing = std::min(spacing_m, length_m / 4.0);
  SideDoors found;
  for (const auto& [begin, end] : runsOf(samples.free, 0, samples.count())) {
    if (static_cast<double>(end - begin) * sample_m < needed_m) continue;
    for (const auto& [from, to] : runsOf(samples.passable, begin, end)) {
      Door door;
      door.from = static_cast<double>(from) / static_cast<double>(samples.count());
      door.to = static_cast<double>(to) / static_cast<double>(samples.count());
      placePortals(length_m, spacing, samples.count(), found, door);
      found.doors.push_back(door);
    }
  }
  return found;
}

void keepIds(const SideDoors& before, SideDoors& doors, std::uint64_t& next_id) {
  std::vector<bool> is_taken(before.doors.size(), false);
  for (Door& door : doors.doors) {
    double most = 0.0;
    std::size_t heir = before.doors.size();
    for (std::size_t i = 0; i < before.doors.size(); ++i) {
      const Door& old = before.doors[i];
      const double common = std::min(door.to, old.to) - std::max(door.from, old.from);
      if (!is_taken[i] && common > most) {
        most = common;
        heir = i;
      }
    }
    if (heir < before.doors.size()) {
      is_taken[heir] = true;
      door.id = before.doors[heir].id;
    } else {
      door.id = next_id++;
    }
  }
}

}  // namespace hymm::core
