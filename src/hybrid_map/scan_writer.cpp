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
  std::size_t beams = 0;
  const Eigen::Vector2d start = T_map_laser.position();
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const auto range = static_cast<double>(scan.ranges_m[i]);
    const bool is_measured = range >= scan.range_min_m && range <= scan.range_max_m;
    const bool is_clear = std::isinf(range) && range > 0.0 && config_.clear_without_return;
    if (!is_measured && !is_clear) continue;
    const bool hits = is_measured && range <= config_.range_m;
    const double length =
        std::min({range, config_.range_m, is_clear ? scan.range_max_m : config_.range_m});
    const double bearing = T_map_laser.yaw_rad + scan.bearing(i);
    const Eigen::Vector2d along(std::cos(bearing), std::sin(bearing));
    writeBeam(start, start + length * along, hits, writer);
    ++beams;
  }
  return beams;
}

void ScanWriter::writeBeam(const Eigen::Vector2d& start, const Eigen::Vector2d& end, bool hits,
                           LayerWriter& writer) {
  const std::vector<BeamPiece>& pieces = cutter_.cut(start, end);
  for (const BeamPiece& piece : pieces) {
    writePiece(piece, start, end, hits && &piece == &pieces.back(), writer);
  }
}

void ScanWriter::writePiece(const BeamPiece& piece, const Eigen::Vector2d& start,
                            const Eigen::Vector2d& end, bool hits, LayerWriter& writer) {
  const Increments gain = increments_;  // a copy, which cells cannot alias
  const Eigen::Vector2d from = start + piece.from * (end - start);
  const Eigen::Vector2d to = start + piece.to * (end - start);
  if (piece.ltr == kNone) {
    WaitingTiles& waiting = writer.waiting();
    const auto cell = [&](int i, int j) -> float& {
      return *waiting.cell(LayerSet::kOccupancy, i, j, writer.revision());
    };
    traverseCells(
        waiting.toCells(from), waiting.toCells(to), [&](int i, int j) { gain.free(cell(i, j)); },
        [&](int i, int j) { hits ? gain.occupy(cell(i, j)) : gain.free(cell(i, j)); });
    return;
  }
  LtrCells& cells = writer.cells(piece.ltr);
  const Triangle& triangle = partition_.mesh().ltr(piece.ltr).triangle;
  float* log_odds = cells.store.write(writer.layers(), LayerSet::kOccupancy, writer.revision());
  int count = 1;
  cells.grid.traverse(
      triangle.toLocal(from), triangle.toLocal(to),
      [&](int index) {
        gain.free(log_odds[index]);
        ++count;
      },
      [&](int index) { hits ? gain.occupy(log_odds[index]) : gain.free(log_odds[index]); });
  partition_.addObservations(piece.ltr, count);
}

}  // namespace hymm::core
