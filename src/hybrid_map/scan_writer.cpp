#include "hybrid_map/scan_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "hybrid_map/cell_traversal.h"
#include "hybrid_map/log_odds.h"
#include "hybrid_map/written_beam.h"

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
  explicit TileWindow(LayerWriter& writer)
      : writer_(writer), origin_(writer.waiting().toCells(Eigen::Vector2d::Zero())) {
    axes_.col(0) = writer.waiting().toCells(Eigen::Vector2d::UnitX()) - origin_;
    axes_.col(1) = writer.waiting().toCells(Eigen::Vector2d::UnitY()) - origin_;
  }

  /// A place in map in units of cells.
  Eigen::Vector2d toCells(const Eigen::Vector2d& place) const { return origin_ + axes_ * place; }

  /// The cells of a tile.
  struct Tile {
    float* log_odds = nullptr;
    CellStore::Stamp* seen = nullptr;
    int corner_i = std::numeric_limits<int>::min(), corner_j = 0;

    unsigned alongI(int i) const {
      return static_cast<unsigned>(i) - static_cast<unsigned>(corner_i);
    }
    unsigned alongJ(int j) const {
      return static_cast<unsigned>(j) - static_cast<unsigned>(corner_j);
    }
    /// Whether both cells are in the tile.
    bool has(int i, int j, int other_i, int other_j) const {
      return (alongI(i) | alongJ(j) | alongI(other_i) | alongJ(other_j)) < unsigned{kTileCells};
    }
    unsigned index(int i, int j) const { return alongJ(j) * unsigned{kTileCells} + alongI(i); }
  };

  /// The tile that has a cell.
  const Tile& tile(int i, int j) {
    const int corner_i = i & ~(kTileCells - 1), corner_j = j & ~(kTileCells - 1);
    const auto slot = [](int corner) { return std::size_t(corner / kTileCells) & (kSlots - 1); };
    Tile& tile = window_[slot(corner_i) * kSlots + slot(corner_j)];
    if (tile.corner_i != corner_i || tile.corner_j != corner_j) tile = find(corner_i, corner_j);
    return tile;
  }

 private:
  static constexpr int kTileCells = WaitingTile::kCells;
  static constexpr std::size_t kSlots = 16;  ///< along a side of the window

  Tile find(int corner_i, int corner_j) {
    CellStore& store = *writer_.waiting().cell(corner_i, corner_j, writer_.revision()).store;
    float* log_odds = store.write(writer_.layers(), LayerSet::kOccupancy, writer_.revision());
    return {log_odds, store.seenCells(LayerSet::kOccupancy), corner_i, corner_j};
  }

  LayerWriter& writer_;
  Eigen::Vector2d origin_;
  Eigen::Matrix2d axes_;
  std::array<Tile, kSlots * kSlots> window_;
};

std::size_t ScanWriter::write(const LaserScan& scan, const Pose2& T_map_laser,
                              LayerWriter& writer) {
  pieces_.clear();
  hits_.clear();
  std::size_t beams = 0;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const std::optional<WrittenBeam> written = writtenBeam(scan, i, config_);
    if (!written) continue;
    const Pose2 T_map_beam = scan.poseAtBeam(i, T_map_laser);
    const double bearing = T_map_beam.yaw_rad + scan.bearing(i);
    const Eigen::Vector2d along(std::cos(bearing), std::sin(bearing));
    const Eigen::Vector2d start = T_map_beam.position();
    cutter_.cut(start, start + written->length_m * along, pieces_);
    if (written->is_hit) addHit(pieces_.back(), writer);
    ++beams;
  }
  chainPieces();
  for (const int ltr : chains_) {
    const int first = std::exchange(first_pieces_[std::size_t(ltr + 1)], kNone);
    if (ltr == kNone) {
      freeOutside(first, writer);
    } else {
      freeInLtr(first, writer);
    }
  }
  occupyHits();
  return beams;
}

void ScanWriter::addHit(const BeamPiece& last, LayerWriter& writer) {
  const Eigen::Vector2d end = last.at(1.0);
  CellPlace place;
  if (last.ltr == kNone) {
    place = writer.waiting().cellAt(end, writer.revision());
  } else {
    LtrCells& cells = writer.cells(last.ltr);
    place = {&cells.store, static_cast<int>(cells.grid.index(end))};
  }
  float* cell =
      place.store->write(writer.layers(), LayerSet::kOccupancy, writer.revision()) + place.index;
  hits_.push_back({place, cell, *cell});
}

/// Pieces in one LTR are written one after the other: they lead into the same cells, and in almost
/// the same direction, which is easier to foresee for the processor. What a cell gains does not
/// depend on the order.
void ScanWriter::chainPieces() {
  static_assert(kNone == -1);
  first_pieces_.resize(std::size_t(partition_.mesh().ltrEnd()) + 1, kNone);
  next_pieces_.resize(pieces_.size());
  chains_.clear();
  for (std::size_t i = pieces_.size(); i-- > 0;) {
    int& first = first_pieces_[std::size_t(pieces_[i].ltr + 1)];
    if (first == kNone) chains_.push_back(pieces_[i].ltr);
    next_pieces_[i] = first;
    first = static_cast<int>(i);
  }
}

void ScanWriter::freeInLtr(int first_piece, LayerWriter& writer) {
  const Increments gain = increments_;  // a copy, which cells cannot alias
  const int ltr = pieces_[std::size_t(first_piece)].ltr;
  LtrCells& cells = writer.cells(ltr);
  float* log_odds = cells.store.write(writer.layers(), LayerSet::kOccupancy, writer.revision());
  int count = 0;
  for (int i = first_piece; i != kNone; i = next_pieces_[std::size_t(i)]) {
    const BeamPiece& piece = pieces_[std::size_t(i)];
    count += cells.grid.changeAlong(piece.at(piece.from), piece.at(piece.to), log_odds,
                                    [gain](float before) { return gain.freed(before); });
  }
  partition_.addObservations(ltr, count);
}

void ScanWriter::freeOutside(int first_piece, LayerWriter& writer) {
  TileWindow window(writer);
  const auto now = static_cast<CellStore::Stamp>(writer.revision());
  const Increments gain = increments_;  // a copy, which cells cannot alias
  TileWindow::Tile tile;                // of the last cells, in which the next ones mostly are, too
  // Both are read before one is written: where they are the same, it is freed once.
  const auto freeBoth = [&](int i, int j, int other_i, int other_j) {
    TileWindow::Tile other_tile = tile;
    if (!tile.has(i, j, other_i, other_j)) {
      tile = window.tile(i, j);
      other_tile = window.tile(other_i, other_j);
    }
    const unsigned one = tile.index(i, j), other = other_tile.index(other_i, other_j);
    const float freed = gain.freed(tile.log_odds[one]);
    const float other_freed = gain.freed(other_tile.log_odds[other]);
    tile.log_odds[one] = freed;
    other_tile.log_odds[other] = other_freed;
    tile.seen[one] = other_tile.seen[other] = now;
  };
  for (int piece = first_piece; piece != kNone; piece = next_pieces_[std::size_t(piece)]) {
    const BeamPiece& beam = pieces_[std::size_t(piece)];
    const CellWalk walk(window.toCells(beam.at(beam.from)), window.toCells(beam.at(beam.to)));
    const int i = walk.start_i, j = walk.start_j;
    if (walk.is_along_i) {
      walk.run([&](int along, int aside, int other) {
        freeBoth(i + along, j + aside, i + along, j + other);
      });
    } else {
      walk.run([&](int along, int aside, int other) {
        freeBoth(i + aside, j + along, i + other, j + along);
      });
    }
  }
}

// Of several beams that end in a cell each counts.
void ScanWriter::occupyHits() {
  for (const Hit& hit : hits_) *hit.cell = hit.before;
  for (const Hit& hit : hits_) {
    *hit.cell = increments_.occupied(*hit.cell);
    if (hit.before > increments_.least && *hit.cell < increments_.most) continue;
    hit.place.store->noteLimit(LayerSet::kOccupancy, hit.place.index);
  }
}

}  // namespace hymm::core
