#include "door_planner/door_map.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "common/error.h"
#include "door_planner/blocked_cells.h"
#include "hybrid_map/input_check.h"
#include "hybrid_map/ltr_geometry.h"

namespace hymm::core {
namespace {

constexpr double kIndexCell_m = 10.0;
/// Of one LTR. What has more cells, or is wider, comes of a message that makes no sense, and its
/// portals would fill the memory.
constexpr std::int64_t kMostCells = 1 << 22;
constexpr double kWidest_m = 1e4;
/// The same goes for numbers of LTRs, by which the index keeps them in a row, and for landmarks
/// that are wider than anything that a robot passes: the index would fill with their cells.
constexpr int kMostLtrs = 1 << 22;
constexpr double kWidestLandmark_m = 100.0;
/// Cells of other LTRs may be that much larger than an LTR's own.
constexpr double kIndexMargin_m = 1.0;
/// By which landmarks and borders may move relative to an LTR before its blocked cells are found
/// anew; so much more is kept away from them.
constexpr double kSolidSlack_m = 0.05;

double factorOf(const LtrView& view) {
  return std::isnan(view.shape_factor) ? 1.0 : std::max(1.0, view.shape_factor);
}

bool isUsable(const LtrView& view) {
  if (view.id < 0 || view.id >= kMostLtrs) return false;
  for (const Eigen::Vector2d& corner : view.corners) {
    if (!isPlace(corner)) return false;
    if (!((corner - view.corners[0]).norm() <= 0.5 * kWidest_m)) return false;
  }
  const std::int64_t cells = std::int64_t{view.alpha_cells} * view.beta_cells;
  return turn(view.corners[0], view.corners[1], view.corners[2]) > 1e-9 && view.alpha_cells > 0 &&
         view.beta_cells > 0 && cells <= kMostCells;
}

/// Largest share by which a length in `before` has grown in `now`.
double stretchOf(const Triangle& now, const Triangle& before) {
  const Eigen::Matrix2d deformation = now.edges() * before.edgesInverse();
  // The larger singular value, by the trace and the determinant of its square.
  const double trace = deformation.squaredNorm(), determinant = deformation.determinant();
  const double root = std::sqrt(std::max(0.0, trace * trace - 4.0 * determinant * determinant));
  return std::sqrt(0.5 * (trace + root));
}

int sideOfKey(const LtrView& view, const SideKey& key) {
  for (int k = 0; k < 3; ++k) {
    if (sideKeyOf(view, k) == key) return k;
  }
  return kNone;
}

/// Of a stretch that does not cross the LTR from side to side.
double distanceOf(const Solid& solid, const Corners& corners, const Triangle& triangle) {
  if (triangle.contains(solid.from)) return 0.0;
  double least = kNoPassing;
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector2d &corner = corners[k], &next = corners[(k + 1) % 3];
    least = std::min({least, distanceToSegment(solid.from, corner, next),
                      distanceToSegment(solid.to, corner, next),
                      distanceToSegment(corner, solid.from, solid.to)});
  }
  return least - solid.radius_m;
}

Eigen::Vector2d lowOf(const Corners& c) { return c[0].cwiseMin(c[1]).cwiseMin(c[2]); }
Eigen::Vector2d highOf(const Corners& c) { return c[0].cwiseMax(c[1]).cwiseMax(c[2]); }

}  // namespace

DoorMap::DoorMap(const DoorPlannerConfig& config)
    : config_(config), index_(kIndexCell_m), landmark_index_(kIndexCell_m) {
  const std::vector<std::string> problems = config_.problems();
  if (!problems.empty()) throw ConfigError(problems);
  std::vector<std::string> ignored;
  weights_ = config_.cost.weights(ignored);
}

std::vector<int> DoorMap::setLtrs(const std::vector<LtrView>& ltrs) {
  is_reshaped_ = true;
  std::vector<int> unusable;
  std::set<int> present;
  std::vector<int> moved, connected_anew;
  for (const LtrView& view : ltrs) {
    if (!isUsable(view)) {
      unusable.push_back(view.id);
      continue;
    }
    present.insert(view.id);
    Region& region = regions_[view.id];
    if (region.view.corners != view.corners) moved.push_back(view.id);
    if (region.view.id == kNone || region.view.neighbours != view.neighbours) {
      connected_anew.push_back(view.id);
    }
    const bool is_same_grid =
        region.view.alpha_cells == view.alpha_cells && region.view.beta_cells == view.beta_cells;
    if (!is_same_grid) region = Region();
    region.view = view;
    region.triangle = Triangle(view.corners);
    index_.place(view.id, lowOf(view.corners), highOf(view.corners));
    touchShape(region);
  }
  for (auto region = regions_.begin(); region != regions_.end();) {
    if (present.count(region->first) > 0) {
      ++region;
      continue;
    }
    if (region->second.costs) blockAround(region->first);
    lookAround(region->second);
    index_.remove(region->first);
    to_block_.erase(region->first);
    to_look_.erase(region->first);
    to_compute_.erase(region->first);
    region = regions_.erase(region);
  }
  for (const int id : moved) {
    to_look_.insert(id);
    if (hasBorder(regions_.at(id))) lookAround(regions_.at(id));
  }
  for (const int id : connected_anew) lookAround(regions_.at(id));
  connectSides();
  return unusable;
}

void DoorMap::setLandmarks(const std::vector<SolidLandmark>& landmarks) {
  std::map<int, SolidLandmark> before = std::move(landmarks_);
  landmarks_.clear();
  landmark_index_ = LtrIndex(kIndexCell_m);
  discs_.clear();
  const double reach_m = 0.5 * config_.vehicle.width_m;
  const auto discOf = [this](const SolidLandmark& landmark) {
    const bool is_told = landmark.diameter_m >= 0.0 && landmark.diameter_m <= kWidestLandmark_m;
    const double diameter_m = is_told ? landmark.diameter_m : config_.landmark_diameter_m;
    return Solid{{landmark.id, landmark.id}, landmark.place, landmark.place, 0.5 * diameter_m};
  };
  const auto changed = [&](const Solid& disc) {
    lookAround(disc.from, disc.from, disc.radius_m + reach_m);
  };
  for (const SolidLandmark& landmark : landmarks) {
    if (!isPlace(landmark.place)) continue;
    landmarks_[landmark.id] = landmark;
    const Solid disc = discOf(landmark);
    const Eigen::Vector2d radius = Eigen::Vector2d::Constant(disc.radius_m);
    landmark_index_.place(static_cast<int>(discs_.size()), disc.from - radius, disc.from + radius);
    discs_.push_back(disc);
    const auto old = before.find(landmark.id);
    const bool is_same = old != before.end() && old->second == landmark;
    if (!is_same) changed(disc);
    if (is_same) before.erase(old);
  }
  for (const auto& [id, landmark] : before) changed(discOf(landmark));
}

/// LTRs near a box, when landmarks or borders in it have changed.
void DoorMap::lookAround(const Eigen::Vector2d& low, const Eigen::Vector2d& high, double reach_m) {
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(reach_m + kIndexMargin_m);
  index_.visit(low - margin, high + margin, [this](int near) { to_look_.insert(near); });
}

void DoorMap::lookAround(const Region& region) {
  if (!config_.outside_is_occupied) return;
  lookAround(lowOf(region.view.corners), highOf(region.view.corners), reach_m(region));
}

bool DoorMap::isBorder(const Region& region, int side) const {
  return regions_.count(region.view.neighbours[std::size_t(side)]) == 0;
}

bool DoorMap::hasBorder(const Region& region) const {
  return isBorder(region, 0) || isBorder(region, 1) || isBorder(region, 2);
}

/// Landmarks and borders in reach of a vehicle in the LTR, in its local coordinates.
std::vector<Solid> DoorMap::solidsNear(const Region& region) const {
  std::vector<Solid> solids;
  const double reach = reach_m(region) + kSolidSlack_m;
  const auto add = [&](Solid solid) {
    // The index is coarse, and its boxes do not turn with the map.
    if (distanceOf(solid, region.view.corners, region.triangle) > reach) return;
    solid.from = region.triangle.toLocal(solid.from);
    solid.to = region.triangle.toLocal(solid.to);
    solids.push_back(solid);
  };
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(reach);
  const Eigen::Vector2d low = lowOf(region.view.corners) - margin;
  const Eigen::Vector2d high = highOf(region.view.corners) + margin;
  landmark_index_.visit(low, high, [&](int disc) { add(discs_[std::size_t(disc)]); });
  if (config_.outside_is_occupied) {
    index_.visit(low, high, [&](int id) {
      const auto near = regions_.find(id);
      if (near == regions_.end()) return;
      const LtrView& view = near->second.view;
      for (int k = 0; k < 3; ++k) {
        if (!isBorder(near->second, k)) continue;
        const auto end = std::size_t(k), next = std::size_t((k + 1) % 3);
        add({{view.landmark_ids[end], view.landmark_ids[next]},
             view.corners[end],
             view.corners[next],
             0.0});
      }
    });
  }
  std::sort(solids.begin(), solids.end(),
            [](const Solid& a, const Solid& b) { return a.landmarks < b.landmarks; });
  return solids;
}

/// What spans an LTR moves with it: only what has moved relative to it, or is another, counts.
void DoorMap::findMovedSolids() {
  for (const int id : to_look_) {
    const auto found = regions_.find(id);
    if (found == regions_.end() || !found->second.costs || to_block_.count(id) > 0) continue;
    const Region& region = found->second;
    const std::vector<Solid> now = solidsNear(region);
    const Eigen::Matrix2d edges = region.triangle.edges();
    const bool keeps =
        std::equal(now.begin(), now.end(), region.solids.begin(), region.solids.end(),
                   [&](const Solid& a, const Solid& b) {
                     const double moved_m = std::max((edges * (a.from - b.from)).norm(),
                                                     (edges * (a.to - b.to)).norm());
                     return a.landmarks == b.landmarks &&
                            moved_m + std::abs(a.radius_m - b.radius_m) <= kSolidSlack_m;
                   });
    if (!keeps) to_block_.insert(id);
  }
  to_look_.clear();
}

// The metric, and with it costs, follow the shape alone; K only scales them, but widens doors.
void DoorMap::touchShape(Region& region) {
  if (!region.in_force) return;
  const Eigen::Matrix2d deformation = region.triangle.edges() * region.computed.edgesInverse();
  const double factor = factorOf(region.view) / region.computed_factor;
  const bool keeps = keepsShape(deformation, 1.0 + config_.shape_tolerance) &&
                     std::abs(std::log(factor)) <= config_.shape_tolerance;
  if (keeps) return;
  region.in_force.reset();
  to_block_.insert(region.view.id);
}

void DoorMap::connectSides() {
  std::map<SideKey, Side> sides;
  for (const auto& [id, region] : regions_) {
    for (int k = 0; k < 3; ++k) {
      const int other = region.view.neighbours[std::size_t(k)];
      const auto found = regions_.find(other);
      if (other <= id || found == regions_.end()) continue;
      const SideKey key = sideKeyOf(region.view, k);
      if (sideOfKey(found->second.view, key) == kNone) continue;
      Side& side = sides[key];
      side.ltrs = {id, other};
      const auto before = sides_.find(key);
      if (before != sides_.end()) side.doors = before->second.doors;
      if (before == sides_.end() || before->second.ltrs != side.ltrs) to_open_.insert(key);
    }
  }
  for (const auto& [key, side] : sides_) {
    if (sides.count(key) > 0) continue;
    // Without its neighbour an LTR has fewer portals.
    for (const int id : side.ltrs) {
      if (regions_.count(id) > 0) to_compute_.insert(id);
    }
    to_open_.erase(key);
  }
  sides_ = std::move(sides);
}

bool DoorMap::setContent(int ltr, const LtrContent& content) {
  const auto found = regions_.find(ltr);
  if (found == regions_.end()) return false;
  Region& region = found->second;
  std::shared_ptr<CellCosts> costs;
  try {
    costs = std::make_shared<CellCosts>(
        config_.cost, weights_, gridOf(region.view.alpha_cells, region.view.beta_cells), content);
  } catch (const std::invalid_argument&) {
    return false;
  }
  ++counts_.contents;
  const bool is_first = !region.costs;
  const bool same_obstacles = !is_first && costs->obstacles() == region.costs->obstacles();
  if (same_obstacles) costs->setBlocked(region.costs->blocked());
  if (same_obstacles && *costs == *region.costs) {
    ++counts_.unchanged_contents;
    return true;
  }
  const bool blocks =
      !costs->obstacles().empty() || (!is_first && !region.costs->obstacles().empty());
  region.costs = std::move(costs);
  to_block_.insert(ltr);
  if (blocks && !same_obstacles) blockAround(ltr);
  return true;
}

double DoorMap::reach_m(const Region& region) const {
  const double cell_m = std::max(region.triangle.edges().col(0).norm() / region.view.alpha_cells,
                                 region.triangle.edges().col(1).norm() / region.view.beta_cells);
  return 0.5 * config_.vehicle.width_m + cell_m;
}

void DoorMap::blockAround(int ltr) {
  const Region& region = regions_.at(ltr);
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(reach_m(region));
  index_.visit(lowOf(region.view.corners) - reach, highOf(region.view.corners) + reach,
               [&](int near) { to_block_.insert(near); });
}

std::vector<bool> DoorMap::blockedCells(const Region& region) const {
  BlockedCells blocked(region.triangle, region.costs->grid(), 0.5 * config_.vehicle.width_m);
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(reach_m(region) + kIndexMargin_m);
  index_.visit(lowOf(region.view.corners) - margin, highOf(region.view.corners) + margin,
               [&](int id) {
                 const auto found = regions_.find(id);
                 if (found == regions_.end() || !found->second.costs) return;
                 blocked.keepAwayFrom(found->second.triangle, *found->second.costs);
               });
  for (Solid solid : region.solids) {
    solid.from = region.triangle.toGlobal(solid.from);
    solid.to = region.triangle.toGlobal(solid.to);
    blocked.keepAwayFrom(solid, kSolidSlack_m);
  }
  for (int cell = 0; cell < region.costs->grid().cellCount(); ++cell) {
    if (region.costs->isOccupied(cell)) blocked.free(cell);
  }
  return blocked.cells();
}

void DoorMap::findBlocked() {
  for (const int id : to_block_) {
    Region& region = regions_.at(id);
    if (!region.costs) continue;
    ++counts_.blocked;
    region.solids = solidsNear(region);
    const std::vector<bool> blocked = blockedCells(region);
    if (blocked != region.costs->blocked()) {
      auto costs = std::make_shared<CellCosts>(*region.costs);
      costs->setBlocked(blocked);
      region.costs = std::move(costs);
    }
    if (region.in_force && *region.in_force == *region.costs) {
      region.costs = region.in_force;
      continue;
    }
    region.in_force = region.costs;
    changed_.insert(id);
    region.computed = region.triangle;
    region.computed_factor = factorOf(region.view);
    to_compute_.insert(id);
    for (int k = 0; k < 3; ++k) {
      const SideKey key = sideKeyOf(region.view, k);
      if (sides_.count(key) > 0) to_open_.insert(key);
    }
  }
  to_block_.clear();
}

/// Stretches of a side that lie in landmarks.
std::vector<std::pair<double, double>> DoorMap::stretchesOf(const Region& region,
                                                            const SideKey& key) const {
  const int side = sideOfKey(region.view, key);
  const Eigen::Vector2d first = region.triangle.toGlobal(placeOnSide(region.view, side, 0.0));
  const Eigen::Vector2d along =
      region.triangle.toGlobal(placeOnSide(region.view, side, 1.0)) - first;
  std::vector<std::pair<double, double>> stretches;
  for (const Solid& solid : region.solids) {
    if (!solid.isLandmark()) continue;
    const Eigen::Vector2d apart = region.triangle.toGlobal(solid.from) - first;
    const double at = apart.dot(along) / along.squaredNorm();
    const double half2 = (solid.radius_m * solid.radius_m - (apart - at * along).squaredNorm()) /
                         along.squaredNorm();
    if (half2 > 0.0) stretches.emplace_back(at - std::sqrt(half2), at + std::sqrt(half2));
  }
  return stretches;
}

SideDoors DoorMap::doorsOf(const SideKey& key, const Side& side) const {
  const Region& one = regions_.at(side.ltrs[0]);
  const Region& other = regions_.at(side.ltrs[1]);
  if (!one.in_force || !other.in_force) return {};
  return core::findDoors({one.view, sideOfKey(one.view, key), *one.in_force},
                         {other.view, sideOfKey(other.view, key), *other.in_force},
                         stretchesOf(one, key), config_.vehicle.width_m, config_.portal_spacing_m);
}

void DoorMap::findDoors() {
  for (const SideKey& key : to_open_) {
    Side& side = sides_.at(key);
    SideDoors found = doorsOf(key, side);
    keepIds(side.doors ? *side.doors : SideDoors(), found, next_door_id_);
    if (side.doors && *side.doors == found) continue;
    is_reshaped_ = true;
    const bool same = side.doors && side.doors->samePlaces(found);
    side.doors = std::make_shared<SideDoors>(std::move(found));
    if (same) continue;
    for (const int id : side.ltrs) to_compute_.insert(id);
  }
  to_open_.clear();
}

void DoorMap::computeMatrix(Region& region) {
  std::vector<Triangle::Local> portals;
  for (int k = 0; k < 3; ++k) {
    const auto side = sides_.find(sideKeyOf(region.view, k));
    if (side == sides_.end() || !side->second.doors) continue;
    for (const double at : side->second.doors->portals) {
      portals.push_back(placeOnSide(region.view, k, at));
    }
  }
  LocalSearch search(region.computed, *region.in_force, config_.max_metric_error);
  region.matrix = std::make_shared<CostMatrix>(search, portals, region.in_force->isDirected());
  ++counts_.matrices;
}

std::size_t DoorMap::prepare(const Eigen::Vector2d& place, std::size_t max_matrices) {
  findMovedSolids();
  findBlocked();
  findDoors();
  std::vector<std::pair<double, int>> order;
  for (const int id : to_compute_) {
    Region& region = regions_.at(id);
    region.matrix.reset();
    changed_.insert(id);
    if (!region.in_force) continue;
    const Eigen::Vector2d centre = region.triangle.toGlobal(Triangle::Local(1.0 / 3, 1.0 / 3));
    order.emplace_back((centre - place).squaredNorm(), id);
  }
  const std::size_t count = std::min(max_matrices, order.size());
  std::partial_sort(order.begin(), order.begin() + std::ptrdiff_t(count), order.end());
  to_compute_.clear();
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i < count) {
      computeMatrix(regions_.at(order[i].second));
    } else {
      to_compute_.insert(order[i].second);
    }
  }
  return to_compute_.size();
}

std::shared_ptr<const DoorGraph> DoorMap::makeGraph() {
  std::shared_ptr<const DoorGraph> made;
  if (graph_ && !is_reshaped_) made = makeByChanges();
  graph_ = made ? made : makeWhole();
  is_reshaped_ = false;
  changed_.clear();
  return graph_;
}

std::shared_ptr<const DoorGraph> DoorMap::makeByChanges() const {
  const std::vector<GraphLtr>& ltrs = graph_->ltrs();
  std::vector<GraphChange> changes;
  for (const int id : changed_) {
    const Region& region = regions_.at(id);
    const auto place =
        std::lower_bound(ltrs.begin(), ltrs.end(), id,
                         [](const GraphLtr& ltr, int wanted) { return ltr.view.id < wanted; });
    GraphChange change;
    change.ltr = static_cast<int>(place - ltrs.begin());
    change.costs = region.in_force;
    if (to_compute_.count(id) == 0) change.matrix = region.matrix;
    if (region.in_force) change.stretch = stretchOf(region.triangle, region.computed);
    changes.push_back(std::move(change));
  }
  return graph_->with(changes);
}

std::shared_ptr<const DoorGraph> DoorMap::makeWhole() const {
  std::vector<GraphLtr> ltrs;
  std::unordered_map<int, int> numbers;
  ltrs.reserve(regions_.size());
  for (const auto& [id, region] : regions_) {
    numbers[id] = static_cast<int>(ltrs.size());
    GraphLtr ltr;
    ltr.view = region.view;
    ltr.triangle = region.triangle;
    ltr.factor = factorOf(region.view);
    ltr.costs = region.in_force;
    if (to_compute_.count(id) == 0) ltr.matrix = region.matrix;
    if (region.in_force) ltr.stretch = stretchOf(region.triangle, region.computed);
    ltrs.push_back(std::move(ltr));
  }
  for (GraphLtr& ltr : ltrs) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto neighbour = numbers.find(ltr.view.neighbours[k]);
      if (neighbour != numbers.end()) ltr.neighbours[k] = neighbour->second;
    }
  }
  std::vector<GraphSide> sides;
  sides.reserve(sides_.size());
  for (const auto& [key, side] : sides_) {
    GraphSide added;
    added.doors = side.doors;
    for (std::size_t i = 0; i < 2; ++i) {
      added.ltrs[i] = numbers.at(side.ltrs[i]);
      GraphLtr& ltr = ltrs[std::size_t(added.ltrs[i])];
      ltr.sides[std::size_t(sideOfKey(ltr.view, key))] = static_cast<int>(sides.size());
    }
    sides.push_back(std::move(added));
  }
  return std::make_shared<DoorGraph>(std::move(ltrs), std::move(sides), config_.max_metric_error);
}

}  // namespace hymm::core
