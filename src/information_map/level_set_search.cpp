#include "information_map/level_set_search.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

namespace hymm::core {
namespace {

using Eigen::Vector2d;

constexpr int kEdge = LevelLattice::kTileEdge;

/// Of samples inside the sets [cells].
constexpr int kSampleSpacing = 8;

/// Of a cell: motions of landmarks below it are added up, not acted on.
constexpr double kMotionTolerance = 0.02;
constexpr double kChangeTolerance = 0.01;

LandmarkWatch::Tolerance toleranceOf(const InformationMapConfig& config) {
  return {kMotionTolerance * config.level_sets.resolution_m, kChangeTolerance,
          config.information.sensor.range_deviation_m, config.information.sensor.region_sigmas};
}

}  // namespace

LevelSetSearch::LevelSetSearch(const InformationMapConfig& config,
                               InformationEvaluator::Occlusion hides)
    : range_m_(config.information.sensor.range_m),
      reach_m_(range_m_ + AchievableInformation::kLargestMargin_m),
      max_cells_(config.level_sets.max_cells),
      cells_(config, std::move(hides)),
      watch_(toleranceOf(config)),
      changed_looks_(range_m_),
      exploration_points_(range_m_) {
  for (int level = 1; level <= lattice().levels(); ++level) islands_.emplace_back(level);
}

void LevelSetSearch::noteChangedLooks(const std::vector<Vector2d>& places, double half_m,
                                      double clearance_m) {
  changed_looks_.note(places, half_m, clearance_m);
}

LevelSetUpdate LevelSetSearch::update(std::shared_ptr<const LandmarkField> field,
                                      const Vector2d& vehicle) {
  LevelSetUpdate outcome;
  outcome.refused = reasonToRefuse(*field);
  if (!outcome.refused.empty()) return outcome;

  if (field_ == nullptr) fill_ = SurroundingsFill(*field, lattice(), reach_m_, vehicle);
  cells_.begin(std::exchange(field_, field), field);
  noteChanges();
  fill_.goOn(cells_);
  changed_looks_.settle(cells_);
  sampleTiles();
  queueBorders(vehicle);
  cells_.spread();
  exploration_points_.explore(cells_);
  cells_.spread();

  was_complete_ = outcome.is_complete =
      cells_.mayEvaluate() && fill_.isDone() && changed_looks_.isDone();
  cells_.end();  // what was queued is found again: it is a border
  for (LevelIslands& islands : islands_) islands.update(lattice());
  outcome.evaluations = cells_.evaluations();
  outcome.levels = cells_.changes();
  return outcome;
}

std::string LevelSetSearch::reasonToRefuse(const LandmarkField& field) const {
  const Vector2d box = field.high() - field.low() + Vector2d::Constant(2.0 * reach_m_);
  const double discs = field.size() * 4.0 * reach_m_ * reach_m_;
  const double area = std::min(box.prod(), discs);
  const double cells = area / lattice().cellArea_m2();
  const double far =
      std::max(field.high().cwiseAbs().maxCoeff(), field.low().cwiseAbs().maxCoeff());
  std::ostringstream text;
  if (cells > max_cells_) {
    text << "level_sets.resolution_m: squares of " << lattice().resolution_m()
         << " m would be up to " << cells << " in the surroundings of " << field.size()
         << " landmarks (" << area << " m^2), more than level_sets.max_cells = " << max_cells_
         << "; choose at least " << std::sqrt(area / max_cells_) << " m, or more cells.";
  } else if ((far + reach_m_) / lattice().resolution_m() > 1e9) {
    text << "A landmark is " << far << " m from the origin, too far for squares of "
         << lattice().resolution_m() << " m; is the landmark map diverging?";
  }
  return text.str();
}

// --- What changed

void LevelSetSearch::noteChanges() {
  certificates().resize(lattice().tileCount());
  certificates().beginChange(static_cast<float>(lattice().resolution_m()));
  struct Largest {
    float moved_m = 0.0F, changed = 0.0F;
  };
  std::vector<Largest> largest(std::size_t(lattice().tileCount()));  // of the landmarks in reach
  for (const ChangedLandmark& change : watch_.compare(cells_.field())) {
    const Cell low = lattice().cellAt(change.place - Vector2d::Constant(reach_m_));
    const Cell high = lattice().cellAt(change.place + Vector2d::Constant(reach_m_));
    constexpr int kBits = LevelLattice::kTileBits;
    for (std::int32_t y = low.y >> kBits; y <= high.y >> kBits; ++y) {
      for (std::int32_t x = low.x >> kBits; x <= high.x >> kBits; ++x) {
        const int tile = lattice().tileOf({x * kEdge, y * kEdge});
        if (tile < 0) continue;
        certificates().tile(tile).is_touched = true;
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
      certificates().addChange(tile, of_tile.moved_m, of_tile.changed);
    }
  }
}

/// A landmark that is new can only add information, one that is gone only take it away.
void LevelSetSearch::revokeNear(int tile, const ChangedLandmark& change) {
  for (int i = 0; i < LevelLattice::kTileCells; ++i) {
    Certificate& certificate = certificates().tile(tile).certificates[std::size_t(i)];
    if (certificate.landmarks < 0) continue;
    const int level = cells_.levelOf(certificate.value);
    if (change.is_new ? level == lattice().levels() : level == 0) continue;
    const Vector2d place = lattice().centre(lattice().cellOf(tile, i));
    if ((place - change.place).squaredNorm() <= range_m_ * range_m_) certificate.landmarks = -1;
  }
}

/// Measures by how much information changed in each tile whose landmarks did.
void LevelSetSearch::sampleTiles() {
  for (int tile = 0; tile < certificates().size(); ++tile) {
    if (certificates().tile(tile).unsampled > 0.0F && cells_.mayEvaluate()) sampleTile(tile);
  }
}

void LevelSetSearch::sampleTile(int tile) {
  const auto tightest = certificates().tightest(tile);
  if (tightest.front() < 0) return;  // nothing here depends on it
  CertificateStore::Tile& of_tile = certificates().tile(tile);
  of_tile.unsampled = 0.0F;
  for (const int i : tightest) {
    if (i < 0) break;
    const Certificate before = of_tile.certificates[std::size_t(i)];
    cells_.settle(lattice().cellOf(tile, i), LevelCells::kOthers);
    if (certificates().addSample(tile, i, before)) return;
  }
  certificates().revokeAll(tile);
}

// --- Borders

void LevelSetSearch::queueBorders(const Vector2d& vehicle) {
  certificates().resize(lattice().tileCount());
  const int vehicle_island = islands_.front().islandOf(lattice(), lattice().cellAt(vehicle));
  for (int tile = 0; tile < lattice().tileCount(); ++tile) {
    CertificateStore::Tile& of_tile = certificates().tile(tile);
    if (was_complete_ && !of_tile.is_touched && !of_tile.is_dirty) continue;
    of_tile.is_dirty = false;
    queueTile(tile, vehicle_island);
  }
}

/// Borders and samples whose evaluation does not hold; other evaluations are forgotten.
void LevelSetSearch::queueTile(int tile, int vehicle_island) {
  const auto isSample = [](const Cell& cell) {
    return (cell.x & (kSampleSpacing - 1)) == kSampleSpacing / 2 &&
           (cell.y & (kSampleSpacing - 1)) == kSampleSpacing / 2;
  };
  const LevelLattice::Tile& levels = lattice().tile(tile);
  CertificateStore::Tile& of_tile = certificates().tile(tile);
  for (int i = 0; i < LevelLattice::kTileCells; ++i) {
    const int level = levels.levels[std::size_t(i)];
    const Cell cell = lattice().cellOf(tile, i);
    if (!lattice().isBorder(tile, i)) {
      Certificate& certificate = of_tile.certificates[std::size_t(i)];
      if (!isSample(cell) && !certificate.is_summit) certificate.landmarks = -1;
      if (!isSample(cell) || level == 0 || !of_tile.is_touched) continue;
    }
    if (certificates().holds(tile, i)) continue;
    const bool is_vehicles =
        vehicle_island >= 0 && islands_.front().islandOf(lattice(), cell) == vehicle_island;
    cells_.queue(cell, is_vehicles ? LevelCells::kVehicle : LevelCells::kOthers);
  }
}

}  // namespace hymm::core
