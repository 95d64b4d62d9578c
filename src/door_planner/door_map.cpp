#include "door_planner/door_map.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "common/error.h"
#include "door_planner/blocked_cells.h"
#include "hybrid_map/ltr_geometry.h"

namespace hymm::core {
namespace {

constexpr double kIndexCell_m = 10.0;
/// Cells of other LTRs may be that much larger than an LTR's own.
constexpr double kIndexMargin_m = 1.0;
/// By which landmarks and borders may move relative to an LTR before its blocked cells are found
/// anew; so much more is kept away from them.
constexpr double kBarrierSlack_m = 0.05;
/// Whose matrices take about a hundredth of a second.
constexpr int kCellsBetweenQuestions = 5000;
/// Looking at the surroundings of an LTR or a side takes as long as so many cells of a matrix, and
/// so many cells are found blocked or not while one gets its costs, about.
constexpr int kCellsOfALook = 10, kBlockedPerCell = 16;

/// Of a stretch that does not cross the LTR from side to side.
double distanceOf(const Barrier& barrier, const Corners& corners, const Triangle& triangle) {
  if (triangle.contains(barrier.from)) return 0.0;
  double least = kNoPassing;
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector2d &corner = corners[k], &next = corners[(k + 1) % 3];
    least = std::min({least, distanceToSegment(barrier.from, corner, next),
                      distanceToSegment(barrier.to, corner, next),
                      distanceToSegment(corner, barrier.from, barrier.to)});
  }
  return least - barrier.radius_m;
}

Eigen::Vector2d lowOf(const Corners& c) { return c[0].cwiseMin(c[1]).cwiseMin(c[2]); }
Eigen::Vector2d highOf(const Corners& c) { return c[0].cwiseMax(c[1]).cwiseMax(c[2]); }

}  // namespace

/// Whether to go on with prepare(): asked of its caller when enough was done since the last time.
class DoorMap::Questions {
 public:
  explicit Questions(const std::function<bool()>& interrupted) : interrupted_(interrupted) {}

  void noteDone(int cells) { done_ += cells; }
  bool endsNow() {
    if (!interrupted_ || done_ < kCellsBetweenQuestions) return false;
    done_ = 0;
    return interrupted_();
  }

 private:
  const std::function<bool()>& interrupted_;
  std::int64_t done_ = 0;
};

DoorMap::DoorMap(const DoorPlannerConfig& config)
    : config_(config), index_(kIndexCell_m), discs_(config.landmark_diameter_m) {
  const std::vector<std::string> problems = config_.problems();
  if (!problems.empty()) throw ConfigError(problems);
  std::vector<std::string> ignored;
  weights_ = config_.cost.weights(ignored);
}

UnusableLtrs DoorMap::setLtrs(const std::vector<LtrView>& ltrs) {
  is_reshaped_ = true;
  UnusableLtrs unusable;
  std::set<int> present;
  std::vector<int> moved, connected_anew;
  for (const LtrView& view : ltrs) {
    if (const std::optional<LtrProblem> problem = problemOf(view)) {
      unusable.emplace(view.id, *problem);
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
    } else {
      forget(region->second);
      region = regions_.erase(region);
    }
  }
  for (const int id : moved) {
    to_look_.insert(id);
    if (hasBorder(regions_.at(id))) lookAround(regions_.at(id));
  }
  for (const int id : connected_anew) lookAround(regions_.at(id));
  connectSides();
  return unusable;
}

/// All that is noted of an LTR that is no more.
void DoorMap::forget(const Region& region) {
  const int id = region.view.id;
  if (region.costs) blockAround(id);
  lookAround(region);
  index_.remove(id);
  to_block_.erase(id);
  to_look_.erase(id);
  to_compute_.erase(id);
}

void DoorMap::setLandmarks(const std::vector<SolidLandmark>& landmarks) {
  for (const Barrier& disc : discs_.set(landmarks)) {
    lookAround(disc.from, disc.from, disc.radius_m + 0.5 * config_.vehicle.width_m);
  }
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
std::vector<Barrier> DoorMap::barriersNear(const Region& region) const {
  std::vector<Barrier> barriers;
  const double reach = reach_m(region) + kBarrierSlack_m;
  const auto add = [&](Barrier barrier) {
    // The index is coarse, and its boxes do not turn with the map.
    if (distanceOf(barrier, region.view.corners, region.triangle) > reach) return;
    barrier.from = region.triangle.toLocal(barrier.from);
    barrier.to = region.triangle.toLocal(barrier.to);
    barriers.push_back(barrier);
  };
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(reach);
  const Eigen::Vector2d low = lowOf(region.view.corners) - margin;
  const Eigen::Vector2d high = highOf(region.view.corners) + margin;
  discs_.visit(low, high, add);
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
  std::sort(barriers.begin(), barriers.end(),
            [](const Barrier& a, const Barrier& b) { return a.landmarks < b.landmarks; });
  return barriers;
}

/// What spans an LTR moves with it: only what has moved relative to it, or is another, counts.
bool DoorMap::hasSameBarriers(const Region& region) const {
  const std::vector<Barrier> now = barriersNear(region);
  const Eigen::Matrix2d edges = region.triangle.edges();
  return std::equal(now.begin(), now.end(), region.barriers.begin(), region.barriers.end(),
                    [&](const Barrier& a, const Barrier& b) {
                      const double moved_m = std::max((edges * (a.from - b.from)).norm(),
                                                      (edges * (a.to - b.to)).norm());
                      return a.landmarks == b.landmarks &&
                             moved_m + std::abs(a.radius_m - b.radius_m) <= kBarrierSlack_m;
                    });
}

// The metric, and with it costs, follow the shape alone; K only scales them, but widens doors.
void DoorMap::touchShape(Region& region) {
  if (!region.in_force) return;
  const Eigen::Matrix2d deformation = region.triangle.edges() * region.computed.edgesInverse();
  const double factor = region.view.factor() / region.computed_factor;
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
      if (findSide(found->second.view, key) == kNone) continue;
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
  for (Barrier barrier : region.barriers) {
    barrier.from = region.triangle.toGlobal(barrier.from);
    barrier.to = region.triangle.toGlobal(barrier.to);
    blocked.keepAwayFrom(barrier, kBarrierSlack_m);
  }
  for (int cell = 0; cell < region.costs->grid().cellCount(); ++cell) {
    if (region.costs->isOccupied(cell)) blocked.free(cell);
  }
  return blocked.cells();
}

void DoorMap::block(Region& region) {
  const int id = region.view.id;
  ++counts_.blocked;
  region.barriers = barriersNear(region);
  const std::vector<bool> blocked = blockedCells(region);
  if (blocked != region.costs->blocked()) {
    auto costs = std::make_shared<CellCosts>(*region.costs);
    costs->setBlocked(blocked);
    region.costs = std::move(costs);
  }
  if (region.in_force && *region.in_force == *region.costs) {
    region.costs = region.in_force;
    return;
  }
  region.in_force = region.costs;
  changed_.insert(id);
  region.computed = region.triangle;
  region.computed_factor = region.view.factor();
  to_compute_.insert(id);
  for (int k = 0; k < 3; ++k) {
    const SideKey key = sideKeyOf(region.view, k);
    if (sides_.count(key) > 0) to_open_.insert(key);
  }
}

/// Stretches of a side that lie in landmarks.
std::vector<std::pair<double, double>> DoorMap::stretchesOf(const Region& region,
                                                            const SideKey& key) const {
  const int side = findSide(region.view, key);
  const Eigen::Vector2d first = region.triangle.toGlobal(placeOnSide(region.view, side, 0.0));
  const Eigen::Vector2d along =
      region.triangle.toGlobal(placeOnSide(region.view, side, 1.0)) - first;
  std::vector<std::pair<double, double>> stretches;
  for (const Barrier& barrier : region.barriers) {
    if (!barrier.isLandmark()) continue;
    const Eigen::Vector2d apart = region.triangle.toGlobal(barrier.from) - first;
    const double at = apart.dot(along) / along.squaredNorm();
    const double half2 =
        (barrier.radius_m * barrier.radius_m - (apart - at * along).squaredNorm()) /
        along.squaredNorm();
    if (half2 > 0.0) stretches.emplace_back(at - std::sqrt(half2), at + std::sqrt(half2));
  }
  return stretches;
}

SideDoors DoorMap::doorsOf(const SideKey& key, const Side& side) const {
  const Region& one = regions_.at(side.ltrs[0]);
  const Region& other = regions_.at(side.ltrs[1]);
  if (!one.in_force || !other.in_force) return {};
  return core::findDoors({one.view, findSide(one.view, key), *one.in_force},
                         {other.view, findSide(other.view, key), *other.in_force},
                         stretchesOf(one, key), config_.vehicle.width_m, config_.portal_spacing_m);
}

void DoorMap::open(const SideKey& key) {
  Side& side = sides_.at(key);
  SideDoors found = doorsOf(key, side);
  keepIds(side.doors ? *side.doors : SideDoors(), found, next_door_id_);
  if (side.doors && *side.doors == found) return;
  is_reshaped_ = true;
  const bool same = side.doors && side.doors->samePlaces(found);
  side.doors = std::make_shared<SideDoors>(std::move(found));
  if (same) return;
  for (const int id : side.ltrs) to_compute_.insert(id);
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

bool DoorMap::findMovedBarriers(Questions& questions) {
  for (; !to_look_.empty(); to_look_.erase(to_look_.begin())) {
    if (questions.endsNow()) return false;
    const int id = *to_look_.begin();
    const auto found = regions_.find(id);
    if (found == regions_.end() || !found->second.costs || to_block_.count(id) > 0) continue;
    if (!hasSameBarriers(found->second)) to_block_.insert(id);
    questions.noteDone(kCellsOfALook);
  }
  return true;
}

bool DoorMap::findBlocked(Questions& questions) {
  for (; !to_block_.empty(); to_block_.erase(to_block_.begin())) {
    if (questions.endsNow()) return false;
    Region& region = regions_.at(*to_block_.begin());
    if (!region.costs) continue;
    block(region);
    questions.noteDone(kCellsOfALook + region.costs->grid().cellCount() / kBlockedPerCell);
  }
  return true;
}

bool DoorMap::findDoors(Questions& questions) {
  for (; !to_open_.empty(); to_open_.erase(to_open_.begin())) {
    if (questions.endsNow()) return false;
    open(*to_open_.begin());
    questions.noteDone(kCellsOfALook);
  }
  return true;
}

bool DoorMap::computeMatrices(const Eigen::Vector2d& place, std::size_t max_matrices,
                              Questions& questions) {
  std::vector<std::pair<double, int>> order;
  for (auto id = to_compute_.begin(); id != to_compute_.end();) {
    Region& region = regions_.at(*id);
    region.matrix.reset();
    changed_.insert(*id);
    if (!region.in_force) {
      id = to_compute_.erase(id);
      continue;
    }
    const Eigen::Vector2d centre = region.triangle.toGlobal(Triangle::Local(1.0 / 3, 1.0 / 3));
    order.emplace_back((centre - place).squaredNorm(), *id++);
  }
  const std::size_t count = std::min(max_matrices, order.size());
  std::partial_sort(order.begin(), order.begin() + std::ptrdiff_t(count), order.end());
  for (std::size_t i = 0; i < count; ++i) {
    if (questions.endsNow()) return false;
    Region& region = regions_.at(order[i].second);
    computeMatrix(region);
    to_compute_.erase(order[i].second);
    questions.noteDone(region.in_force->grid().cellCount());
  }
  return true;
}

std::size_t DoorMap::prepare(const Eigen::Vector2d& place, std::size_t max_matrices,
                             const std::function<bool()>& interrupted) {
  Questions questions(interrupted);
  const bool is_known = findMovedBarriers(questions) && findBlocked(questions) &&
                        findDoors(questions) && computeMatrices(place, max_matrices, questions);
  return to_compute_.size() + (is_known ? 0 : to_look_.size() + to_block_.size() + to_open_.size());
}

}  // namespace hymm::core
