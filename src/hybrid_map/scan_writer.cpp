#include "hybrid_map/scan_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

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

/// The waiting tiles around the sensor, whose cells are found without a search.
class ScanWriter::TileWindow {
 public:
  TileWindow(WaitingTiles& tiles, std::uint64_t revision)
      : tiles_(tiles), revision_(revision), origin_(tiles.toCells(Eigen::Vector2d::Zero())) {
    axes_.col(0) = tiles.toCells(Eigen::Vector2d::UnitX()) - origin_;
    axes_.col(1) = tiles.toCells(Eigen::Vector2d::UnitY()) - origin_;
  }

  /// A place in map in units of cells.
  Eigen::Vector2d toCells(const Eigen::Vector2d& place) const { return origin_ + axes_ * place; }

  /// The occupancy of the tile that has a cell; its first cell becomes (`corner_i`, `corner_j`).
  float* tileOf(int i, int j, int& corner_i, int& corner_j) {
    corner_i = i & ~(kTileCells - 1);
    corner_j = j & ~(kTileCells - 1);
    const auto slot = [](int corner) { return std::size_t(corner / kTileCells) & (kSlots - 1); };
    Tile& tile = window_[slot(corner_i) * kSlots + slot(corner_j)];
    if (tile.first == nullptr || tile.corner_i != corner_i || tile.corner_j != corner_j) {
      tile = {tiles_.cell(LayerSet::kOccupancy, corner_i, corner_j, revision_), corner_i, corner_j};
    }
    return tile.first;
  }

  static constexpr int kTileCells = WaitingTile::kCells;

 private:
  static constexpr std::size_t kSlots = 16;  ///< along a side of the window
  struct Tile {
    float* first = nullptr;
    int corner_i = 0, corner_j = 0;
  };

  WaitingTiles& tiles_;
  std::uint64_t revision_;
  Eigen::Vector2d origin_;
  Eigen::Matrix2d axes_;
  std::array<Tile, kSlots * kSlots> window_;
};

std::size_t ScanWriter::write(const LaserScan& scan, const Pose2& T_map_laser,
                              LayerWriter& writer) {
  pieces_.clear();
  hits_.clear();
  std::size_t beams = 0;
  const Eigen::Vector2d start = T_map_laser.position();
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const auto range = static_cast<double>(scan.ranges_m[i]);
    // No return is told by infinity or the maximum; what lies beyond may as well be a mask.
    const bool is_measured = scan.isHit(range);
    const bool has_no_return = range > 0.0 && (std::isinf(range) || range == scan.range_max_m);
    const bool is_clear = has_no_return && config_.clear_without_return;
    if (!is_measured && !is_clear) continue;
    const double length =
        std::min({range, config_.range_m, is_clear ? scan.range_max_m : config_.range_m});
    const double bearing = T_map_laser.yaw_rad + scan.bearing(i);
    const Eigen::Vector2d along(std::cos(bearing), std::sin(bearing));
    cutter_.cut(start, start + length * along, pieces_);
    if (is_measured && range <= config_.range_m) addHit(pieces_.back(), writer);
    ++beams;
  }
  TileWindow window(writer.waiting(), writer.revision());
  for (const BeamPiece& piece : pieces_) {
    if (piece.ltr == kNone) {
      freeOutside(piece, window);
    } else {
      freeInLtr(piece, writer);
    }
  }
  occupyHits();
  return beams;
}

void ScanWriter::addHit(const BeamPiece& last, LayerWriter& writer) {
  const Eigen::Vector2d end = last.at(1.0);
  float* cell = nullptr;
  if (last.ltr == kNone) {
    const Eigen::Vector2d at = writer.waiting().toCells(end);
    cell = writer.waiting().cell(LayerSet::kOccupancy, static_cast<int>(std::floor(at.x())),
                                 static_cast<int>(std::floor(at.y())), writer.revision());
  } else {
    LtrCells& cells = writer.cells(last.ltr);
    cell = cells.store.write(writer.layers(), LayerSet::kOccupancy, writer.revision()) +
           cells.grid.index(end);
  }
  hits_.push_back({cell, *cell});
}

void ScanWriter::freeInLtr(const BeamPiece& piece, LayerWriter& writer) {
  const Increments gain = increments_;  // a copy, which cells cannot alias
  LtrCells& cells = writer.cells(piece.ltr);
  float* log_odds = cells.store.write(writer.layers(), LayerSet::kOccupancy, writer.revision());
  const int count = cells.grid.changeAlong(piece.at(piece.from), piece.at(piece.to), log_odds,
                                           [gain](float before) { return gain.freed(before); });
  partition_.addObservations(piece.ltr, count);
}

void ScanWriter::freeOutside(const BeamPiece& piece, TileWindow& window) {
  constexpr int kTileCells = TileWindow::kTileCells;
  const Increments gain = increments_;  // a copy, which cells cannot alias
  const Eigen::Vector2d from = window.toCells(piece.at(piece.from));
  int corner_i = std::numeric_limits<int>::min(), corner_j = 0;
  float* first = nullptr;
  traverseCells(from, window.toCells(piece.at(piece.to)), [&](int i, int j) {
    auto in_i = static_cast<unsigned>(i) - static_cast<unsigned>(corner_i);
    auto in_j = static_cast<unsigned>(j) - static_cast<unsigned>(corner_j);
    if ((in_i | in_j) >= unsigned{kTileCells}) {
      first = window.tileOf(i, j, corner_i, corner_j);
      in_i = static_cast<unsigned>(i - corner_i);
      in_j = static_cast<unsigned>(j - corner_j);
    }
    float& log_odds = first[in_j * unsigned{kTileCells} + in_i];
    log_odds = gain.freed(log_odds);
  });
}

// Of several beams that end in a cell each counts.
void ScanWriter::occupyHits() {
  for (const Hit& hit : hits_) *hit.cell = hit.before;
  for (const Hit& hit : hits_) *hit.cell = increments_.occupied(*hit.cell);
}

}  // namespace hymm::core
