#include "hybrid_map/scan_writer.h"

#include <algorithm>
#include <cmath>

#include "hybrid_map/cell_traversal.h"
#include "hybrid_map/log_odds.h"

namespace hymm::core {

ScanWriter::ScanWriter(const OccupancyConfig& config, LtrPartition& partition)
    : config_(config),
      partition_(partition),
      cutter_(partition.mesh()),
      increments_{static_cast<float>(logOddsOf(config.hit_probability)),
                  static_cast<float>(logOddsOf(config.miss_probability)),
                  static_cast<float>(logOddsOf(config.min_probability)),
                  static_cast<float>(logOddsOf(config.max_probability))} {}

std::size_t ScanWriter::write(const LaserScan& scan, const Pose2& T_map_laser,
                              LayerWriter& writer) {
  pieces_.clear();
  hits_.clear();
  std::size_t beams = 0;
  const Eigen::Vector2d start = T_map_laser.position();
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const auto range = static_cast<double>(scan.ranges_m[i]);
    const bool is_measured = range >= scan.range_min_m && range <= scan.range_max_m;
    const bool is_clear = std::isinf(range) && range > 0.0 && config_.clear_without_return;
    if (!is_measured && !is_clear) continue;
    const double length =
        std::min({range, config_.range_m, is_clear ? scan.range_max_m : config_.range_m});
    const double bearing = T_map_laser.yaw_rad + scan.bearing(i);
    const Eigen::Vector2d along(std::cos(bearing), std::sin(bearing));
    cutBeam(start, start + length * along);
    if (is_measured && range <= config_.range_m) addHit(pieces_.back(), writer);
    ++beams;
  }
  for (const Piece& piece : pieces_) freeAlong(piece, writer);
  occupyHits();
  return beams;
}

void ScanWriter::cutBeam(const Eigen::Vector2d& start, const Eigen::Vector2d& end) {
  const Eigen::Vector2d along = end - start;
  for (const BeamPiece& piece : cutter_.cut(start, end)) {
    pieces_.push_back({piece.ltr, start + piece.from * along, start + piece.to * along});
  }
}

void ScanWriter::addHit(const Piece& last, LayerWriter& writer) {
  float* cell = nullptr;
  if (last.ltr == kNone) {
    const Eigen::Vector2d at = writer.waiting().toCells(last.to);
    cell = writer.waiting().cell(LayerSet::kOccupancy, static_cast<int>(std::floor(at.x())),
                                 static_cast<int>(std::floor(at.y())), writer.revision());
  } else {
    LtrCells& cells = writer.cells(last.ltr);
    const Triangle& triangle = partition_.mesh().ltr(last.ltr).triangle;
    cell = cells.store.write(writer.layers(), LayerSet::kOccupancy, writer.revision()) +
           cells.grid.index(triangle.toLocal(last.to));
  }
  hits_.push_back({cell, *cell});
}

void ScanWriter::freeAlong(const Piece& piece, LayerWriter& writer) {
  if (piece.ltr == kNone) {
    freeAlongWaiting(piece, writer.waiting(), writer.revision());
    return;
  }
  const Increments gain = increments_;  // a copy, which cells cannot alias
  LtrCells& cells = writer.cells(piece.ltr);
  const Triangle& triangle = partition_.mesh().ltr(piece.ltr).triangle;
  float* log_odds = cells.store.write(writer.layers(), LayerSet::kOccupancy, writer.revision());
  const int count =
      cells.grid.changeAlong(triangle.toLocal(piece.from), triangle.toLocal(piece.to), log_odds,
                             [gain](float before) { return gain.freed(before); });
  partition_.addObservations(piece.ltr, count);
}

void ScanWriter::freeAlongWaiting(const Piece& piece, WaitingTiles& waiting,
                                  std::uint64_t revision) {
  const Increments gain = increments_;  // a copy, which cells cannot alias
  WaitingTiles::Cursor cursor(waiting, revision);
  traverseCells(waiting.toCells(piece.from), waiting.toCells(piece.to), [&](int i, int j) {
    float& log_odds = cursor.at(i, j);
    log_odds = gain.freed(log_odds);
  });
}

// Of several beams that end in a cell each counts.
void ScanWriter::occupyHits() {
  for (const Hit& hit : hits_) *hit.cell = hit.before;
  for (const Hit& hit : hits_) *hit.cell = increments_.occupied(*hit.cell);
}

}  // namespace hymm::core
