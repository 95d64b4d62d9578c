#include "information_map/level_cells.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/error.h"

namespace hymm::core {
namespace {

/// Of a cell, which is as fine as a border gets: motions of landmarks below it never call for
/// another evaluation. Where headings or occlusion decide what is visible, this is the margin.
constexpr double kGrantedMargin = 0.1;

std::vector<double> usableValues(const InformationMapConfig& config) {
  std::vector<std::string> problems = config.problems();
  if (!problems.empty()) throw ConfigError(problems);
  return config.level_sets.valuesAscending(problems);
}

}  // namespace

LevelCells::LevelCells(const InformationMapConfig& config, InformationEvaluator::Occlusion hides)
    : values_(usableValues(config)),
      keeps_losses_(config.level_sets.losses == "keep"),
      evaluator_(config.information, std::move(hides)),
      lattice_(config.level_sets.resolution_m, static_cast<int>(values_.size())),
      certificates_(static_cast<float>(kGrantedMargin * config.level_sets.resolution_m)),
      budget_(static_cast<std::size_t>(config.level_sets.max_evaluations)),
      range_m_(config.information.sensor.range_m) {}

void LevelCells::begin(std::shared_ptr<const LandmarkField> before,
                       std::shared_ptr<const LandmarkField> now) {
  field_before_ = std::move(before);
  field_ = std::move(now);
  evaluations_before_ = evaluator_.counts().evaluations;
  changes_.assign(values_.size(), LevelChange{});
  motion_.reset();
  if (field_before_) motion_.emplace(*field_before_, *field_, range_m_);
}

void LevelCells::end() {
  for (std::deque<Cell>& queue : queues_) queue.clear();
  motion_.reset();
  field_before_.reset();
  for (int level = 1; level <= lattice_.levels(); ++level) {
    changes_[std::size_t(level - 1)].area_m2 = lattice_.area_m2(level);
  }
}

int LevelCells::levelOf(double information) const {
  return static_cast<int>(std::upper_bound(values_.begin(), values_.end(), information) -
                          values_.begin());
}

int LevelCells::tileOf(const Cell& cell) {
  const int tile = lattice_.makeTileOf(cell);
  certificates_.resize(lattice_.tileCount());
  return tile;
}

const Certificate& LevelCells::certificate(const Cell& cell) const {
  return certificates_.tile(lattice_.tileOf(cell))
      .certificates[std::size_t(LevelLattice::indexInTile(cell))];
}

bool LevelCells::holds(const Cell& cell) const {
  const int tile = lattice_.tileOf(cell);
  return tile >= 0 && tile < certificates_.size() &&
         certificates_.holds(tile, LevelLattice::indexInTile(cell));
}

int LevelCells::evaluate(const Cell& cell) {
  const AchievableInformation information = evaluator_.at(*field_, lattice_.centre(cell));
  double slack = Certificate::kUnlimited;  // without information only other landmarks help
  for (const double value : values_) {
    if (!(information.value > 0.0)) break;
    slack = std::min(slack, std::abs(std::log(information.value / value)));
  }
  certificates_.certify(tileOf(cell), LevelLattice::indexInTile(cell), information, slack);
  return levelOf(information.value);
}

void LevelCells::revoke(const Cell& cell) {
  certificates_.tile(tileOf(cell))
      .certificates[std::size_t(LevelLattice::indexInTile(cell))]
      .landmarks = -1;
}

void LevelCells::settle(const Cell& cell, Priority priority) {
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
bool LevelCells::keepsLoss(const Cell& cell, int before, int measured) {
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

void LevelCells::spread() {
  for (const Priority priority : {kVehicle, kOthers}) {
    std::deque<Cell>& queue = queues_[priority];
    while (!queue.empty() && mayEvaluate()) {
      const Cell cell = queue.front();
      queue.pop_front();
      if (!holds(cell)) settle(cell, priority);
    }
  }
}

}  // namespace hymm::core
