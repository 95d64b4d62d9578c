#include "information_map/level_set_search.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "common/error.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;

constexpr int kEdge = LevelLattice::kTileEdge;

/// Edge of the blocks that a fill from scratch starts with, and spacing of samples inside the sets
/// [cells].
constexpr int kBlockBits = 3;
constexpr int kBlock = 1 << kBlockBits;

/// Of a cell: motions of landmarks below it are added up, not acted on.
constexpr double kMotionTolerance = 0.02;
constexpr double kChangeTolerance = 0.01;

/// Of a cell, which is as fine as a border gets: motions of landmarks below it never call for
/// another evaluation. Where headings or occlusion decide what is visible, this is the margin.
constexpr double kGrantedMargin = 0.1;

std::vector<double> usableValues(const InformationMapConfig& config) {
  std::vector<std::string> problems = config.problems();
  if (!problems.empty()) throw ConfigError(problems);
  return config.level_sets.valuesAscending(problems);
}

LandmarkWatch::Tolerance toleranceOf(const InformationMapConfig& config) {
  return {kMotionTolerance * config.level_sets.resolution_m, kChangeTolerance,
          config.information.sensor.range_deviation_m, config.information.sensor.region_sigmas};
}

}  // namespace

LevelSetSearch::LevelSetSearch(const InformationMapConfig& config,
                               InformationEvaluator::Occlusion hides)
    : config_(config),
      values_(usableValues(config)),
      reach_m_(config.information.sensor.range_m + AchievableInformation::kLargestMargin_m),
      keeps_losses_(config.level_sets.losses == "keep"),
      evaluator_(config.information, std::move(hides)),
      lattice_(config.level_sets.resolution_m, static_cast<int>(values_.size())),
      certificates_(static_cast<float>(kGrantedMargin * config.level_sets.resolution_m)),
      watch_(toleranceOf(config)),
      budget_(static_cast<std::size_t>(config.level_sets.max_evaluations)) {
  for (int level = 1; level <= lattice_.levels(); ++level) islands_.emplace_back(level);
}

LevelSetUpdate LevelSetSearch::update(std::shared_ptr<const LandmarkField> field,
                                      const Vector2d& vehicle) {
  LevelSetUpdate outcome;
  outcome.refused = reasonToRefuse(*field);
  if (!outcome.refused.empty()) return outcome;

  const bool is_first = field_ == nullptr;
  const std::shared_ptr<const LandmarkField> before = std::exchange(field_, std::move(field));
  evaluations_before_ = evaluations();
  changes_.assign(values_.size(), LevelChange{});
  motion_.reset();
  if (before) motion_.emplace(*before, *field_, config_.information.sensor.range_m);
  noteChanges();
  if (is_first) fillSurroundings(vehicle);
  fillWaiting();
  sampleTiles();
  queueBorders(vehicle);
  spread();
  explore();
  spread();

  was_complete_ = outcome.is_complete = mayEvaluate() && to_fill_.empty();
  for (std::deque<Cell>& queue : queues_) queue.clear();  // found again: they are borders
  motion_.reset();
  outcome.evaluations = evaluations() - evaluations_before_;
  for (int level = 1; level <= lattice_.levels(); ++level) {
    islands_[std::size_t(level - 1)].update(lattice_);
    changes_[std::size_t(level - 1)].area_m2 = lattice_.area_m2(level);
  }
  outcome.levels = changes_;
  return outcome;
}

std::string LevelSetSearch::reasonToRefuse(const LandmarkField& field) const {
  const Vector2d box = field.high() - field.low() + Vector2d::Constant(2.0 * reach_m_);
  const double discs = field.size() * 4.0 * reach_m_ * reach_m_;
  const double area = std::min(box.prod(), discs);
  const double cells = area / lattice_.cellArea_m2();
  const double far =
      std::max(field.high().cwiseAbs().maxCoeff(), field.low().cwiseAbs().maxCoeff());
  std::ostringstream text;
  if (cells > config_.level_sets.max_cells) {
    text << "level_sets.resolution_m: squares of " << lattice_.resolution_m()
         << " m would be up to " << cells << " in the surroundings of " << field.size()
         << " landmarks (" << area
         << " m^2), more than level_sets.max_cells = " << config_.level_sets.max_cells
         << "; choose at least " << std::sqrt(area / config_.level_sets.max_cells)
         << " m, or more cells.";
  } else if ((far + reach_m_) / lattice_.resolution_m() > 1e9) {
    text << "A landmark is " << far << " m from the origin, too far for squares of "
         << lattice_.resolution_m() << " m; is the landmark map diverging?";
  }
  return text.str();
}

// --- From scratch
// ---------------------------------------------------------------------------------

/// Lists the blocks that are within reach of a landmark, those near the vehicle last.
void LevelSetSearch::fillSurroundings(const Vector2d& vehicle) {
  for (int i = 0; i < field_->size(); ++i) {
    const Cell low = lattice_.cellAt(field_->position(i) - Vector2d::Constant(reach_m_));
    const Cell high = lattice_.cellAt(field_->position(i) + Vector2d::Constant(reach_m_));
    for (std::int32_t y = low.y >> kBlockBits; y <= high.y >> kBlockBits; ++y) {
      for (std::int32_t x = low.x >> kBlockBits; x <= high.x >> kBlockBits; ++x) {
        to_fill_.push_back({x * kBlock, y * kBlock});
      }
    }
  }
  const auto distance = [&](const Cell& cell) {
    return (lattice_.centre({cell.x + kBlock / 2, cell.y + kBlock / 2}) - vehicle).squaredNorm();
  };
  std::sort(to_fill_.begin(), to_fill_.end(), [&](const Cell& a, const Cell& b) {
    const double to_a = distance(a), to_b = distance(b);
    if (to_a != to_b) return to_a > to_b;
    return a.y != b.y ? a.y < b.y : a.x < b.x;
  });
  to_fill_.erase(std::unique(to_fill_.begin(), to_fill_.end()), to_fill_.end());
}

void LevelSetSearch::fillWaiting() {
  while (!to_fill_.empty() && mayEvaluate()) {
    fillBlock(to_fill_.back(), kBlock);
    to_fill_.pop_back();
  }
}

/// A quadtree from above: a block whose corners and centre agree is filled, another one is split.
void LevelSetSearch::fillBlock(const Cell& low, int edge) {
  const int last = edge - 1, middle = edge / 2;
  const std::array<Cell, 5> probes = {{{low.x, low.y},
                                       {low.x + last, low.y},
                                       {low.x, low.y + last},
                                       {low.x + last, low.y + last},
                                       {low.x + middle, low.y + middle}}};
  int least = lattice_.levels(), most = 0;
  for (const Cell& probe : probes) {
    const int level = holds(probe) ? levelOf(certificate(probe).value) : evaluate(probe);
    lattice_.set(probe, level);
    least = std::min(least, level);
    most = std::max(most, level);
  }
  if (edge <= 2) return;
  if (least < most) {
    const int half = edge / 2;
    for (const auto& [dx, dy] : {std::pair{0, 0}, {half, 0}, {0, half}, {half, half}}) {
      fillBlock({low.x + dx, low.y + dy}, half);
    }
    return;
  }
  for (int y = 0; y < edge; ++y) {
    for (int x = 0; x < edge; ++x) lattice_.set({low.x + x, low.y + y}, least);
  }
}

// --- What changed
// ---------------------------------------------------------------------------------

void LevelSetSearch::noteChanges() {
  certificates_.resize(lattice_.tileCount());
  certificates_.beginChange(static_cast<float>(lattice_.resolution_m()));
  struct Largest {
    float moved_m = 0.0F, changed = 0.0F;
  };
  std::vector<Largest> largest(std::size_t(lattice_.tileCount()));  // of the landmarks in reach
  for (const ChangedLandmark& change : watch_.compare(*field_)) {
    const Cell low = lattice_.cellAt(change.place - Vector2d::Constant(reach_m_));
    const Cell high = lattice_.cellAt(change.place + Vector2d::Constant(reach_m_));
    constexpr int kBits = LevelLattice::kTileBits;
    for (std::int32_t y = low.y >> kBits; y <= high.y >> kBits; ++y) {
      for (std::int32_t x = low.x >> kBits; x <= high.x >> kBits; ++x) {
        const int tile = lattice_.tileOf({x * kEdge, y * kEdge});
        if (tile < 0) continue;
        certificates_.tile(tile).is_touched = true;
        if (change.is_new || change.is_gone) revokeNear(tile, change);
        Largest& of_tile = largest[std::size_t(tile)];
        of_tile.moved_m = std::max(of_tile.moved_m, static_cast<float>(change.moved_m));
        of_tile.changed = std::max(of_tile.changed, static_cast<float>(change.changed));
      }
    }
  }
  for (int tile = 0; tile < static_cast<int>(largest.size()); ++tile) {
    const Largest& of_tile = largest[std::size_t(tile)];
    if (of_tile.moved_m > 0.0F || of_tile.changed > 0.0F) {
      certificates_.addChange(tile, of_tile.moved_m, of_tile.changed);
    }
  }
}

/// A landmark that is new can only add information, one that is gone only take it away.
void LevelSetSearch::revokeNear(int tile, const ChangedLandmark& change) {
  const double range_m = config_.information.sensor.range_m;
  for (int i = 0; i < LevelLattice::kTileCells; ++i) {
    Certificate& certificate = certificates_.tile(tile).certificates[std::size_t(i)];
    if (certificate.landmarks < 0) continue;
    const int level = levelOf(certificate.value);
    if (change.is_new ? level == lattice_.levels() : level == 0) continue;
    const Vector2d place = lattice_.centre(lattice_.cellOf(tile, i));
    if ((place - change.place).squaredNorm() <= range_m * range_m) certificate.landmarks = -1;
  }
}

/// Measures by how much information changed in each tile whose landmarks did.
void LevelSetSearch::sampleTiles() {
  for (int tile = 0; tile < certificates_.size(); ++tile) {
    if (certificates_.tile(tile).unsampled > 0.0F && mayEvaluate()) sampleTile(tile);
  }
}

void LevelSetSearch::sampleTile(int tile) {
  const auto tightest = certificates_.tightest(tile);
  if (tightest.front() < 0) return;  // nothing here depends on it
  CertificateStore::Tile& of_tile = certificates_.tile(tile);
  of_tile.unsampled = 0.0F;
  for (const int i : tightest) {
    if (i < 0) break;
    const Certificate before = of_tile.certificates[std::size_t(i)];
    evaluateAndSettle(lattice_.cellOf(tile, i), kOthers);
    if (certificates_.addSample(tile, i, before)) return;
  }
  certificates_.revokeAll(tile);
}

// --- Borders
// --------------------------------------------------------------------------------------

void LevelSetSearch::queueBorders(const Vector2d& vehicle) {
  certificates_.resize(lattice_.tileCount());
  const int vehicle_island = islands_.front().islandOf(lattice_, lattice_.cellAt(vehicle));
  for (int tile = 0; tile < lattice_.tileCount(); ++tile) {
    CertificateStore::Tile& of_tile = certificates_.tile(tile);
    if (was_complete_ && !of_tile.is_touched && !of_tile.is_dirty) continue;
    of_tile.is_dirty = false;
    queueTile(tile, vehicle_island);
  }
}

/// Borders and samples whose evaluation does not hold; other evaluations are forgotten.
void LevelSetSearch::queueTile(int tile, int vehicle_island) {
  const auto isSample = [](const Cell& cell) {
    return (cell.x & (kBlock - 1)) == kBlock / 2 && (cell.y & (kBlock - 1)) == kBlock / 2;
  };
  const LevelLattice::Tile& levels = lattice_.tile(tile);
  CertificateStore::Tile& of_tile = certificates_.tile(tile);
  for (int i = 0; i < LevelLattice::kTileCells; ++i) {
    const int level = levels.levels[std::size_t(i)];
    const Cell cell = lattice_.cellOf(tile, i);
    if (!lattice_.isBorder(tile, i)) {
      Certificate& certificate = of_tile.certificates[std::size_t(i)];
      if (!isSample(cell) && !certificate.is_summit) certificate.landmarks = -1;
      if (!isSample(cell) || level == 0 || !of_tile.is_touched) continue;
    }
    if (certificates_.holds(tile, i)) continue;
    const bool is_vehicles =
        vehicle_island >= 0 && islands_.front().islandOf(lattice_, cell) == vehicle_island;
    queues_[is_vehicles ? kVehicle : kOthers].push_back(cell);
  }
}

void LevelSetSearch::spread() {
  for (const Priority priority : {kVehicle, kOthers}) {
    std::deque<Cell>& queue = queues_[priority];
    while (!queue.empty() && mayEvaluate()) {
      const Cell cell = queue.front();
      queue.pop_front();
      if (!holds(cell)) evaluateAndSettle(cell, priority);
    }
  }
}

// --- Exploration points
// ---------------------------------------------------------------------------

/// From landmarks that are not in the highest set (paper IV-A). A climb is repeated when its
/// outcome does not hold any more.
void LevelSetSearch::explore() {
  for (int i = 0; i < field_->size() && mayEvaluate(); ++i) {
    const Vector2d& place = field_->position(i);
    if (lattice_.levelAt(place) == lattice_.levels()) continue;
    const auto summit = summits_.find(field_->id(i));
    if (summit != summits_.end() && holds(summit->second)) continue;
    std::optional<Cell> highest;
    for (const Vector2d& start : explorationPoints(place)) {
      const std::optional<Cell> reached = climb(start);
      if (!reached) return;
      if (!highest || certificate(*reached).value > certificate(*highest).value) highest = reached;
    }
    summits_[field_->id(i)] = *highest;
    certificates_.tile(tileOf(*highest))
        .certificates[std::size_t(LevelLattice::indexInTile(*highest))]
        .is_summit = true;
    spread();
  }
}

/// At a landmark, and half a range from it on four sides.
std::array<Vector2d, 5> LevelSetSearch::explorationPoints(const Vector2d& landmark) const {
  const double far_m = 0.5 * config_.information.sensor.range_m;
  return {landmark, landmark + Vector2d(far_m, 0.0), landmark - Vector2d(far_m, 0.0),
          landmark + Vector2d(0.0, far_m), landmark - Vector2d(0.0, far_m)};
}

/// Steps to the best of four neighbours, halving the step where none is better. Of cells without
/// information, the one with more landmarks in view is better. Nothing if the evaluations ran out.
std::optional<Cell> LevelSetSearch::climb(const Vector2d& start) {
  const auto heightOf = [this](const Cell& cell) {
    if (!holds(cell)) evaluateAndSettle(cell, kVehicle);
    return std::pair{certificate(cell).value, certificate(cell).landmarks};
  };
  Cell best = lattice_.cellAt(start);
  auto height = heightOf(best);
  int step = std::max(
      1, static_cast<int>(0.5 * config_.information.sensor.range_m / lattice_.resolution_m()));
  while (step >= 1 && levelOf(height.first) < lattice_.levels()) {
    Cell better = best;
    for (const Cell& direction : LevelLattice::kNeighbours) {
      if (!mayEvaluate()) return std::nullopt;
      const Cell cell{best.x + step * direction.x, best.y + step * direction.y};
      const auto here = heightOf(cell);
      if (here > height) {
        height = here;
        better = cell;
      }
    }
    if (better == best) step /= 2;
    best = better;
  }
  return best;
}

// --- Single cells
// ---------------------------------------------------------------------------------

int LevelSetSearch::levelOf(double information) const {
  return static_cast<int>(std::upper_bound(values_.begin(), values_.end(), information) -
                          values_.begin());
}

int LevelSetSearch::tileOf(const Cell& cell) {
  const int tile = lattice_.makeTileOf(cell);
  certificates_.resize(lattice_.tileCount());
  return tile;
}

const Certificate& LevelSetSearch::certificate(const Cell& cell) const {
  return certificates_.tile(lattice_.tileOf(cell))
      .certificates[std::size_t(LevelLattice::indexInTile(cell))];
}

bool LevelSetSearch::holds(const Cell& cell) const {
  const int tile = lattice_.tileOf(cell);
  return tile >= 0 && tile < certificates_.size() &&
         certificates_.holds(tile, LevelLattice::indexInTile(cell));
}

/// Evaluates i(X) at a cell's centre, certifies it, and returns its level.
int LevelSetSearch::evaluate(const Cell& cell) {
  const AchievableInformation information = evaluator_.at(*field_, lattice_.centre(cell));
  double slack = Certificate::kUnlimited;  // without information only other landmarks help
  for (const double value : values_) {
    if (!(information.value > 0.0)) break;
    slack = std::min(slack, std::abs(std::log(information.value / value)));
  }
  certificates_.certify(tileOf(cell), LevelLattice::indexInTile(cell), information, slack);
  return levelOf(information.value);
}

/// Gives a cell the level measured, or what the policy on losses makes of it. Where its level
/// changed, neighbours of other levels follow.
void LevelSetSearch::evaluateAndSettle(const Cell& cell, Priority priority) {
  const int measured = evaluate(cell);
  const int before = lattice_.level(cell);
  if (measured == before || (measured < before && keepsLoss(cell, before, measured))) return;
  for (int level = before + 1; level <= measured; ++level) {
    changes_[std::size_t(level - 1)].gained_m2 += lattice_.cellArea_m2();
  }
  lattice_.set(cell, measured);
  certificates_.tile(tileOf(cell)).is_dirty = true;
  for (const Cell& step : LevelLattice::kNeighbours) {
    const Cell neighbour{cell.x + step.x, cell.y + step.y};
    certificates_.tile(tileOf(neighbour)).is_dirty = true;
    if (lattice_.level(neighbour) != measured && !holds(neighbour)) {
      queues_[priority].push_back(neighbour);
    }
  }
}

/// Counts what a cell loses, and says whether the set keeps it all the same.
bool LevelSetSearch::keepsLoss(const Cell& cell, int before, int measured) {
  const bool keeps = keeps_losses_ && !certificates_.tile(tileOf(cell)).lets_go;
  int moving = measured;
  if (motion_ && motion_->largest_m() > 0.0) {
    moving = levelOf(evaluator_.at(*field_, motion_->move(lattice_.centre(cell))).value);
  }
  for (int level = measured + 1; level <= before; ++level) {
    LevelChange& change = changes_[std::size_t(level - 1)];
    change.lost_m2 += lattice_.cellArea_m2();
    if (moving < level) change.lost_moving_m2 += lattice_.cellArea_m2();
    if (keeps) change.kept_m2 += lattice_.cellArea_m2();
  }
  return keeps;
}

}  // namespace hymm::core
