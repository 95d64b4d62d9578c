/// How what sheets hold of the same places comes together.
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <unordered_map>
#include <unordered_set>

#include <Eigen/Eigenvalues>

#include "hybrid_map/cell_shares.h"
#include "hybrid_map/pair_covariances.h"
#include "hybrid_map/waiting_tiles.h"

namespace hymm::core {
namespace {

// Along the line between two sheets, both keep what they saw this near to it: else a gap would open
// where they move apart.
constexpr double kSeam_m = 0.5;

double largestDeviation(const Eigen::Matrix2d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, axes.eigenvalues()[1]));
}

/// How well landmarks are known relative to each other.
class RelativeDeviations {
 public:
  RelativeDeviations(const LandmarkMap& map, const std::unordered_set<int>& ids)
      : pairs_(map, ids) {
    for (const LandmarkEstimate& landmark : map.landmarks) {
      if (ids.count(landmark.id) > 0) covariances_[landmark.id] = landmark.covariance;
    }
  }

  /// Of one landmark's place relative to another's [m], in the direction in which it is largest;
  /// where their covariance is not told, the most that it can be. Infinite for unknown landmarks.
  double between(int one, int other) const {
    const auto a = covariances_.find(one), b = covariances_.find(other);
    if (a == covariances_.end() || b == covariances_.end()) {
      return std::numeric_limits<double>::infinity();
    }
    if (one == other) return 0.0;
    const auto cross = pairs_.block(one, other);
    if (!cross) return largestDeviation(a->second) + largestDeviation(b->second);
    return largestDeviation(a->second + b->second - *cross - cross->transpose());
  }

  /// Of any of the one relative to any of the other.
  double largest(const std::array<int, 2>& ones, const std::array<int, 2>& others) const {
    double largest = 0.0;
    for (const int one : ones) {
      for (const int other : others) largest = std::max(largest, between(one, other));
    }
    return largest;
  }

 private:
  PairCovariances pairs_;
  std::unordered_map<int, Eigen::Matrix2d> covariances_;
};

bool intersect(const WaitingTiles::Box& a, const WaitingTiles::Box& b) {
  return (a.low.array() <= b.high.array()).all() && (b.low.array() <= a.high.array()).all();
}

}  // namespace

/// Moves cells of one sheet into tiles of another, on the other's side of the line halfway between
/// their anchors, as if what was written later had been written on top of the other.
class WaitingTiles::CellMove {
 public:
  CellMove(const WaitingTiles& tiles, Sheet& from, Sheet& to, const Eigen::Vector2d& from_middle,
           const Eigen::Vector2d& to_middle, std::uint64_t revision)
      : layers_(tiles.layers_),
        from_(from),
        to_(to),
        is_later_(from.written > to.written),
        revision_(revision) {
    const Pose2 T_to_from = inverse(to.T_map_sheet) * from.T_map_sheet;
    const Pose2 T_from_map = inverse(from.T_map_sheet);
    turn_ = T_to_from.rotation();
    shift_ = T_to_from.position() / tiles.resolution_m_;
    halfway_ = T_from_map * (0.5 * (from_middle + to_middle)) / tiles.resolution_m_;
    towards_ = T_from_map.rotation() * (to_middle - from_middle).normalized();
    seam_ = kSeam_m / tiles.resolution_m_;
    for (std::size_t i = 0; i < kCellParts.size(); ++i) parts_[i] = turn_ * kCellParts[i];
  }

  void run() {
    if (is_later_) makeRoom();
    for (auto tile = from_.tiles.begin(); tile != from_.tiles.end();) {
      bool is_empty = false;
      if (mayMove(tile->first)) {
        is_empty = true;
        for (int layer = 0; layer < layers_.count(); ++layer) {
          is_empty = moveLayer(tile->first, tile->second, layer) && is_empty;
        }
      }
      tile = is_empty ? from_.tiles.erase(tile) : std::next(tile);
    }
  }

 private:
  /// A place in units of cells of `from` in those of `to`.
  Eigen::Vector2d toOther(const Eigen::Vector2d& place) const { return turn_ * place + shift_; }
  /// Whether a place, in units of cells, is beyond the seam by more than `least`.
  bool isBeyondSeam(const Eigen::Vector2d& place, double least = 0.0) const {
    return (place - halfway_).dot(towards_) - seam_ > least;
  }

  bool mayMove(const TilePlace& place) {
    const Eigen::Vector2d middle =
        kTileCells * Eigen::Vector2d(place.first + 0.5, place.second + 0.5);
    if (!isBeyondSeam(middle, -kTileCells * M_SQRT1_2)) return false;
    const Eigen::Array2d tile = (toOther(middle) / kTileCells).array().floor();
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        const TilePlace other(static_cast<int>(tile.x()) + x, static_cast<int>(tile.y()) + y);
        if (to_.tiles.count(other) > 0) return true;
      }
    }
    return false;
  }

  /// Of all cells first: parts of several come to one, and must not make it forget each other.
  void makeRoom() {
    for (const auto& [place, tile] : from_.tiles) {
      if (!mayMove(place)) continue;
      for (int layer = 0; layer < layers_.count(); ++layer) {
        if (tile.isEmpty(layer)) continue;
        const CellModel& model = layers_.model(layer);
        for (int index = 0; index < tile.cellCount(); ++index) {
          const float* cell = tile.read(layers_, layer, index);
          const Eigen::Vector2d corner = cornerOf(place, index);
          if (!hasEvidence(cell, layers_.channels(layer)) || !isBeyondSeam(middleOf(corner))) {
            continue;
          }
          const std::size_t parts = partsOf(model, cell);
          const float share = 1.0F / static_cast<float>(parts);
          visitTargets(corner, layer, parts,
                       [&](float* target) { model.yieldTo(cell, share, target); });
        }
      }
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
    const std::uint64_t before = tile.revision(layer);
    float* cell = tile.write(layers_, layer, before);
    bool is_empty = true, has_moved = false;
    for (int index = 0; index < tile.cellCount(); ++index, cell += channels) {
      if (!hasEvidence(cell, channels)) continue;
      const Eigen::Vector2d corner = cornerOf(place, index);
      const std::size_t parts = partsOf(layers_.model(layer), cell);
      const std::size_t moved =
          isBeyondSeam(middleOf(corner)) ? moveCell(corner, layer, cell, parts) : 0;
      const float left = static_cast<float>(parts - moved) / static_cast<float>(parts);
      if (moved > 0) layers_.model(layer).keep(left, cell);
      has_moved = has_moved || moved > 0;
      is_empty = is_empty && moved == parts;
    }
    if (has_moved) tile.write(layers_, layer, revision_);
    return is_empty;
  }

  /// Returns how many of the first `parts` of the cell found a tile.
  std::size_t moveCell(const Eigen::Vector2d& corner, int layer, const float* cell,
                       std::size_t parts) {
    const CellModel& model = layers_.model(layer);
    const float share = 1.0F / static_cast<float>(parts);
    return visitTargets(corner, layer, parts, [&](float* target) {
      if (is_later_) {
        model.merge(cell, share, target);
        return;
      }
      earlier_.assign(cell, cell + layers_.channels(layer));
      model.yieldTo(target, 1.0F, earlier_.data());
      model.merge(earlier_.data(), share, target);
    });
  }

  /// Visits the cells to which the first `parts` of a cell belong. Returns how many found a tile.
  template <class Visit>
  std::size_t visitTargets(const Eigen::Vector2d& corner, int layer, std::size_t parts,
                           Visit&& visit) {
    const Eigen::Vector2d other = toOther(corner);
    std::size_t found = 0;
    for (std::size_t part = 0; part < parts; ++part) {
      const Eigen::Vector2d at = other + parts_[part];
      const int i = static_cast<int>(std::floor(at.x())), j = static_cast<int>(std::floor(at.y()));
      const int in_i = i & (kTileCells - 1), in_j = j & (kTileCells - 1);
      CellStore* tile = tileAt({(i - in_i) / kTileCells, (j - in_j) / kTileCells});
      if (tile == nullptr) continue;
      visit(tile->write(layers_, layer, revision_) +
            std::ptrdiff_t{in_j * kTileCells + in_i} * layers_.channels(layer));
      ++found;
    }
    return found;
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

  const LayerSet& layers_;
  Sheet &from_, &to_;
  bool is_later_;  ///< whether `from` was written after `to`
  std::uint64_t revision_;
  Eigen::Matrix2d turn_;               ///< from cells of `from` to those of `to`
  Eigen::Vector2d shift_;              ///< likewise
  Eigen::Vector2d halfway_, towards_;  ///< in cells of `from`
  double seam_;                        ///< cells
  std::array<Eigen::Vector2d, kCellParts.size()> parts_;
  std::vector<float> earlier_;  ///< a cell
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

void WaitingTiles::join(const LandmarkMap& map, const LandmarkPlaces& landmarks,
                        double most_deviation_m, std::uint64_t revision) {
  last_tile_ = nullptr;
  struct Candidate {
    Sheet* sheet;
    std::array<int, 2> anchors;  ///< as they are called now
    Eigen::Vector2d middle;
    Box box;
  };
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < sheets_.size(); ++i) {
    Sheet& sheet = sheets_[i];
    const std::array<int, 2> anchors = {landmarks.presentId(sheet.anchors.first),
                                        landmarks.presentId(sheet.anchors.second)};
    if (i == selected_ || anchors[0] < 0 || anchors[1] < 0) continue;
    candidates.push_back({&sheet, anchors, anchorMiddle(sheet, landmarks), boxOf(sheet)});
  }
  const auto areJoined = [this](const Candidate& a, const Candidate& b) {
    const auto joined = joined_.find({a.sheet->id, b.sheet->id});
    return joined != joined_.end() &&
           joined->second >= std::max(a.sheet->written, b.sheet->written);
  };
  std::vector<std::pair<const Candidate*, const Candidate*>> pairs;
  std::unordered_set<int> ids;
  for (auto a = candidates.begin(); a != candidates.end(); ++a) {
    for (auto b = a + 1; b != candidates.end(); ++b) {
      if (areJoined(*a, *b) || !intersect(a->box, b->box)) continue;
      pairs.emplace_back(&*a, &*b);
      for (const Candidate& one : {*a, *b}) ids.insert(one.anchors.begin(), one.anchors.end());
    }
  }
  if (pairs.empty()) return;  // as with most maps: spares a look at all their covariances
  const RelativeDeviations deviations(map, ids);
  for (const auto& [a, b] : pairs) {
    if (deviations.largest(a->anchors, b->anchors) > most_deviation_m) continue;
    CellMove(*this, *a->sheet, *b->sheet, a->middle, b->middle, revision).run();
    CellMove(*this, *b->sheet, *a->sheet, b->middle, a->middle, revision).run();
    joined_[{a->sheet->id, b->sheet->id}] = revision;
    a->sheet->written = b->sheet->written = std::max(a->sheet->written, b->sheet->written);
  }
}

}  // namespace hymm::core
