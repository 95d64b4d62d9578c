/// How what sheets hold of the same places comes together.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_set>
#include <vector>

#include <Eigen/Core>

#include "hybrid_map/cell_shares.h"
#include "hybrid_map/relative_deviations.h"
#include "hybrid_map/waiting_tiles.h"

namespace hymm::core {
namespace {

// Along the line between two sheets, both keep what they saw this near to it: else a gap would open
// where they move apart.
constexpr double kSeam_m = 0.5;

// Cells that two sheets, or the line between them, may have moved by since they were joined, for
// what was written before to be where it belongs still.
constexpr double kMostMoved = 0.5;

bool intersect(const WaitingTiles::Box& a, const WaitingTiles::Box& b) {
  return (a.low.array() <= b.high.array()).all() && (b.low.array() <= a.high.array()).all();
}

}  // namespace

/// Moves cells of one sheet into tiles of another, on the other's side of the line halfway between
/// their anchors, as if what was seen later had been written on top of the other. Where there is no
/// such line, as the anchors are the same, the sheet that was begun first takes all.
class WaitingTiles::CellMove {
 public:
  CellMove(const WaitingTiles& tiles, Sheet& from, Sheet& to, const Eigen::Vector2d& from_middle,
           const Eigen::Vector2d& to_middle, std::uint64_t joined, std::uint64_t revision)
      : tiles_(tiles),
        layers_(tiles.layers_),
        from_(from),
        to_(to),
        joined_(joined),
        revision_(revision),
        overlay_(tiles.layers_, revision) {
    const Pose2 T_to_from = inverse(to.T_map_sheet) * from.T_map_sheet;
    const Pose2 T_from_map = inverse(from.T_map_sheet);
    turn_ = T_to_from.rotation();
    shift_ = T_to_from.position() / tiles.resolution_m_;
    halfway_ = T_from_map * (0.5 * (from_middle + to_middle)) / tiles.resolution_m_;
    const Eigen::Vector2d apart = to_middle - from_middle;
    if (apart.norm() > kSeam_m) {
      towards_ = T_from_map.rotation() * apart.normalized();
      seam_ = kSeam_m / tiles.resolution_m_;
    } else {  // as when anchors were merged with the other's
      towards_.setZero();
      seam_ = (from.id > to.id ? -1.0 : 1.0) * std::numeric_limits<double>::infinity();
    }
    for (std::size_t i = 0; i < kCellParts.size(); ++i) parts_[i] = turn_ * kCellParts[i];
  }

  void run() {
    std::vector<TilePlace> places;
    for (const auto& [place, tile] : from_.tiles) {
      if (mayMove(place, tile)) places.push_back(place);
    }
    for (int layer = 0; layer < layers_.count(); ++layer) {
      if (!layers_.model(layer).hasLimits()) continue;
      for (const TilePlace& place : places) makeRoom(place, from_.tiles.at(place), layer);
    }
    for (const TilePlace& place : places) {
      bool is_empty = true;
      for (int layer = 0; layer < layers_.count(); ++layer) {
        is_empty = moveLayer(place, from_.tiles.at(place), layer) && is_empty;
      }
      if (is_empty) emptied_.push_back(from_.tiles.extract(place));
    }
  }

  /// After the move in the other direction, which asks what was seen later before either.
  void finish() { overlay_.finish(); }

 private:
  /// A place in units of cells of `from` in those of `to`.
  Eigen::Vector2d toOther(const Eigen::Vector2d& place) const { return turn_ * place + shift_; }
  /// Whether a place, in units of cells, is beyond the seam by more than `least`.
  bool isBeyondSeam(const Eigen::Vector2d& place, double least = 0.0) const {
    return (place - halfway_).dot(towards_) - seam_ > least;
  }

  /// Of a tile where nothing was written since the last time, nor in those that it lies on, all has
  /// moved that may. At that revision something may have come from a third sheet afterwards.
  bool mayMove(const TilePlace& place, const CellStore& from) const {
    const Eigen::Vector2d middle =
        kTileCells * Eigen::Vector2d(place.first + 0.5, place.second + 0.5);
    if (!isBeyondSeam(middle, -kTileCells * M_SQRT1_2)) return false;
    const Eigen::Array2d tile = (toOther(middle) / kTileCells).array().floor();
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        const TilePlace other(static_cast<int>(tile.x()) + x, static_cast<int>(tile.y()) + y);
        const auto found = to_.tiles.find(other);
        if (found == to_.tiles.end()) continue;
        if (std::max(from.lastRevision(), found->second.lastRevision()) >= joined_) return true;
      }
    }
    return false;
  }

  void makeRoom(const TilePlace& place, const CellStore& tile, int layer) {
    if (tile.isEmpty(layer)) return;
    for (int index = 0; index < tile.cellCount(); ++index) {
      const float* cell = tile.read(layers_, layer, index);
      const Eigen::Vector2d corner = cornerOf(place, index);
      if (!hasEvidence(cell, layers_.channels(layer)) || !isBeyondSeam(middleOf(corner))) continue;
      visitTargets(
          corner, tiles_.movingPart(tile, layer, index),
          [&](const CellPart& part, CellPlace target) { overlay_.makeRoom(part, target); });
    }
  }

  static Eigen::Vector2d cornerOf(const TilePlace& place, int index) {
    return {place.first * kTileCells + index % kTileCells,
            place.second * kTileCells + index / kTileCells};
  }
  static Eigen::Vector2d middleOf(const Eigen::Vector2d& corner) {
    return corner + Eigen::Vector2d(0.5, 0.5);
  }

  /// Returns whether nothing is left.
  bool moveLayer(const TilePlace& place, CellStore& tile, int layer) {
    if (tile.isEmpty(layer)) return true;
    const int channels = layers_.channels(layer);
    float* cell = tile.rearrange(layers_, layer, tile.revision(layer));
    bool is_empty = true, has_moved = false;
    for (int index = 0; index < tile.cellCount(); ++index, cell += channels) {
      if (!hasEvidence(cell, channels)) continue;
      const Eigen::Vector2d corner = cornerOf(place, index);
      const bool moves =
          isBeyondSeam(middleOf(corner)) &&
          visitTargets(corner, tiles_.movingPart(tile, layer, index),
                       [&](const CellPart& part, CellPlace target) { overlay_.add(part, target); });
      if (moves) tile.keep(layers_, layer, index, 0.0F);
      has_moved = has_moved || moves;
      is_empty = is_empty && moves;
    }
    if (has_moved) tile.rearrange(layers_, layer, revision_);
    return is_empty;
  }

  /// Visits the cells to which the parts of a cell belong, if there are tiles for all of them.
  /// Returns whether there are.
  template <class Visit>
  bool visitTargets(const Eigen::Vector2d& corner, const CellPart& part, Visit&& visit) {
    const Eigen::Vector2d other = toOther(corner);
    std::array<CellPlace, kCellParts.size()> targets;
    for (std::size_t i = 0; i < part.count; ++i) {
      const Eigen::Vector2d at = other + parts_[i];
      const int x = static_cast<int>(std::floor(at.x())), y = static_cast<int>(std::floor(at.y()));
      const int in_x = x & (kTileCells - 1), in_y = y & (kTileCells - 1);
      CellStore* tile = tileAt({(x - in_x) / kTileCells, (y - in_y) / kTileCells});
      if (tile == nullptr) return false;
      targets[i] = {tile, in_y * kTileCells + in_x};
    }
    for (std::size_t i = 0; i < part.count; ++i) visit(part, targets[i]);
    return true;
  }

  CellStore* tileAt(const TilePlace& place) {
    if (!has_looked_ || place != last_place_) {
      const auto found = to_.tiles.find(place);
      last_tile_ = found == to_.tiles.end() ? nullptr : &found->second;
      last_place_ = place;
      has_looked_ = true;
    }
    return last_tile_;
  }

  const WaitingTiles& tiles_;
  const LayerSet& layers_;
  Sheet &from_, &to_;
  std::uint64_t joined_;  ///< the last time, as they lie now; 0: never
  std::uint64_t revision_;
  CellOverlay overlay_;
  /// To these, too, something may have come from the other sheet.
  std::vector<std::map<TilePlace, CellStore>::node_type> emptied_;
  Eigen::Matrix2d turn_;               ///< from cells of `from` to those of `to`
  Eigen::Vector2d shift_;              ///< likewise
  Eigen::Vector2d halfway_, towards_;  ///< in cells of `from`
  double seam_;                        ///< cells
  std::array<Eigen::Vector2d, kCellParts.size()> parts_;
  CellStore* last_tile_ = nullptr;
  TilePlace last_place_{};
  bool has_looked_ = false;
};

Eigen::Vector2d WaitingTiles::anchorMiddle(const Sheet& sheet,
                                           const LandmarkPlaces& landmarks) const {
  const auto first = landmarks.find(sheet.anchors.first);
  const auto second = landmarks.find(sheet.anchors.second);
  return first && second ? Eigen::Vector2d(0.5 * (*first + *second)) : centreOf(sheet);
}

WaitingTiles::Box WaitingTiles::boxOf(const Sheet& sheet) const {
  const double tile_m = kTileCells * resolution_m_;
  Box box{Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()),
          Eigen::Vector2d::Constant(-std::numeric_limits<double>::infinity())};
  for (const auto& [place, tile] : sheet.tiles) {
    const Eigen::Vector2d middle(place.first + 0.5, place.second + 0.5);
    const Eigen::Vector2d centre = sheet.T_map_sheet * (tile_m * middle);
    box.low = box.low.cwiseMin((centre.array() - tile_m * M_SQRT1_2).matrix());
    box.high = box.high.cwiseMax((centre.array() + tile_m * M_SQRT1_2).matrix());
  }
  return box;
}

std::vector<WaitingTiles::Joinable> WaitingTiles::joinableSheets(const LandmarkPlaces& landmarks) {
  std::vector<Joinable> joinable;
  for (std::size_t i = 0; i < sheets_.size(); ++i) {
    Sheet& sheet = sheets_[i];
    const std::array<int, 2> anchors = {landmarks.presentId(sheet.anchors.first),
                                        landmarks.presentId(sheet.anchors.second)};
    if (i == selected_ || anchors[0] < 0 || anchors[1] < 0) continue;
    joinable.push_back({&sheet, anchors, anchorMiddle(sheet, landmarks), boxOf(sheet)});
  }
  return joinable;
}

bool WaitingTiles::mayHaveToJoin(const Joinable& a, const Joinable& b) const {
  const auto joined = joined_.find({a.sheet->id, b.sheet->id});
  const std::uint64_t last = joined == joined_.end() ? 0 : joined->second.revision;
  return last < std::max(a.sheet->written, b.sheet->written) && intersect(a.box, b.box);
}

void WaitingTiles::joinPair(const Joinable& a, const Joinable& b, std::uint64_t revision) {
  const Pose2 T_a_map = inverse(a.sheet->T_map_sheet), T_b_map = inverse(b.sheet->T_map_sheet);
  Joined::Places middles;
  middles << T_a_map * a.middle, T_a_map * b.middle, T_b_map * a.middle, T_b_map * b.middle;
  Joined& joined = joined_[{a.sheet->id, b.sheet->id}];
  const double moved_m = (middles - joined.middles).colwise().norm().maxCoeff();
  const std::uint64_t last = moved_m <= kMostMoved * resolution_m_ ? joined.revision : 0;
  CellMove there(*this, *a.sheet, *b.sheet, a.middle, b.middle, last, revision);
  CellMove back(*this, *b.sheet, *a.sheet, b.middle, a.middle, last, revision);
  there.run();
  back.run();
  there.finish();
  back.finish();
  joined = {revision, middles};
  a.sheet->written = b.sheet->written = std::max(a.sheet->written, b.sheet->written);
}

void WaitingTiles::join(const LandmarkMap& map, const LandmarkPlaces& landmarks,
                        double most_deviation_m, std::uint64_t revision) {
  last_tile_ = nullptr;
  const std::vector<Joinable> sheets = joinableSheets(landmarks);
  std::vector<std::pair<const Joinable*, const Joinable*>> pairs;
  std::unordered_set<int> ids;
  for (auto a = sheets.begin(); a != sheets.end(); ++a) {
    for (auto b = a + 1; b != sheets.end(); ++b) {
      if (!mayHaveToJoin(*a, *b)) continue;
      pairs.emplace_back(&*a, &*b);
      for (const Joinable* one : {&*a, &*b}) ids.insert(one->anchors.begin(), one->anchors.end());
    }
  }
  if (pairs.empty()) return;  // as with most maps: spares a look at all their covariances
  const RelativeDeviations deviations(map, ids);
  for (const auto& [a, b] : pairs) {
    if (deviations.largest(a->anchors, b->anchors) <= most_deviation_m) joinPair(*a, *b, revision);
  }
}

}  // namespace hymm::core
