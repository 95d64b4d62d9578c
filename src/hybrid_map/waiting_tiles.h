#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "cekf/landmark_map.h"
#include "common/config.h"
#include "common/pose2.h"
#include "hybrid_map/cell_overlay.h"
#include "hybrid_map/cell_store.h"
#include "hybrid_map/landmark_places.h"

namespace hymm::core {

struct WaitingConfig {
  double anchor_range_m = 20.0;
  double max_memory_mb = 64.0;

  void describe(ConfigSchema& schema);

  /// Memory [MB] that what one scan sees up to `range_m` takes at most, where there is no LTR.
  static double scanMemory_mb(double range_m, double resolution_m);
};

/// A square of cells that wait for an LTR, for reading.
struct WaitingTile {
  static constexpr int kCells = 32;  ///< along a side

  std::uint64_t sheet = 0;  ///< identity of the sheet that it is a part of
  int x = 0, y = 0;         ///< its place in the sheet
  Pose2 T_map_cells;        ///< the least corner of its first cell, and the direction of its rows
  double resolution_m = 0.0;
  const CellStore* cells = nullptr;
};

/// Observations outside of every LTR wait here until one covers them. They lie in square cells of a
/// sheet, which moves with the two landmarks that it is anchored to (one, or none, where there are
/// no more), and is written only near them. What two sheets hold of one place comes together in the
/// one whose anchors are nearer, once it is known how the sheets lie to each other, as if what was
/// seen later had been written on top.
class WaitingTiles {
 public:
  /// `layers` outlives the object.
  WaitingTiles(const WaitingConfig& config, const LayerSet& layers, double resolution_m);

  /// Chooses the sheet for what is written next, near `place` in map.
  void select(const Eigen::Vector2d& place, const LandmarkPlaces& landmarks);

  /// Of the selected sheet: a place in map in units of its cells.
  Eigen::Vector2d toCells(const Eigen::Vector2d& place) const {
    return T_cells_map_ * place / resolution_m_;
  }

  /// The cell (i, j) of the selected sheet for writing; valid until the sheets change.
  CellPlace cell(int i, int j, std::uint64_t revision);
  /// The same for a place in map.
  CellPlace cellAt(const Eigen::Vector2d& place, std::uint64_t revision);

  /// Moves the sheets with their landmarks.
  void follow(const LandmarkPlaces& landmarks);

  /// Joins what sheets hold of the same places, where no landmark that one is anchored to is less
  /// certain than `most_deviation_m` relative to those of the other: a cell goes into the sheet
  /// whose anchors are nearer. The sheet that is being written is left alone until another is
  /// selected. `landmarks` are those of `map`.
  void join(const LandmarkMap& map, const LandmarkPlaces& landmarks, double most_deviation_m,
            std::uint64_t revision);

  struct Box {
    Eigen::Vector2d low, high;
  };
  /// Takes over what waited, sheet by sheet.
  class Taker {
   public:
    virtual ~Taker() = default;
    /// Of all parts of the sheet, if the layer's model has limits; `place` in map.
    virtual void makeRoom(const CellPart& part, const Eigen::Vector2d& place) = 0;
    /// Of all parts of the sheet. Returns whether it took the part, which then is no longer here.
    virtual bool take(const CellPart& part, const Eigen::Vector2d& place) = 0;
    /// After each sheet.
    virtual void finish() = 0;
  };
  /// Offers the evidence in all tiles that touch one of the boxes (in map).
  void settle(const std::vector<Box>& boxes, Taker& taker);

  /// Drops the tiles that were not written for longest, and among equals those farthest from
  /// `vehicle` (in map), until the rest fits the memory. Returns how many.
  std::size_t dropBeyondLimit(const Eigen::Vector2d& vehicle);

  /// Compresses tiles beyond `radius_m` of a place that were not written since a revision.
  void packBeyond(const Eigen::Vector2d& place, double radius_m, std::uint64_t since_revision);

  CellMemory memory() const;
  bool isEmpty() const { return sheets_.empty(); }

  /// Calls `visit(WaitingTile)` for each tile in which a layer was written.
  template <class Visitor>
  void visitTiles(int layer, Visitor&& visitor) const {
    const double tile_m = kTileCells * resolution_m_;
    for (const Sheet& sheet : sheets_) {
      for (const auto& [at, cells] : sheet.tiles) {
        if (cells.isEmpty(layer)) continue;
        const Pose2 T_sheet_cells{tile_m * at.first, tile_m * at.second, 0.0};
        visitor(WaitingTile{sheet.id, at.first, at.second, sheet.T_map_sheet * T_sheet_cells,
                            resolution_m_, &cells});
      }
    }
  }

  void save(StateWriter& archive) const;
  void restore(StateReader& archive);

  /// Evidence of a layer in all tiles.
  double evidence(int layer) const;

 private:
  static constexpr int kTileCells = WaitingTile::kCells;
  static constexpr CellStore::Seen kSeen = CellStore::Seen::kCells;
  using TilePlace = std::pair<int, int>;

  struct Sheet {
    std::uint64_t id = 0;
    std::pair<int, int> anchors{-1, -1};  ///< landmark ids
    Pose2 T_map_sheet;
    Pose2 T_anchors_sheet;
    std::map<TilePlace, CellStore> tiles;
    /// The map's revision when it, or what has come to it, was last selected and written: since
    /// then there may be something to join. When it was seen, each cell knows itself.
    std::uint64_t written = 0;
  };

  Pose2 anchorFrame(const std::pair<int, int>& anchors, const LandmarkPlaces& landmarks) const;
  bool areThere(const std::pair<int, int>& anchors, const LandmarkPlaces& landmarks) const;
  bool suits(const Sheet& sheet, const Eigen::Vector2d& place,
             const LandmarkPlaces& landmarks) const;
  std::size_t nearestSuiting(const Eigen::Vector2d& place, const LandmarkPlaces& landmarks) const;
  void anchor(Sheet& sheet, const Eigen::Vector2d& place, const LandmarkPlaces& landmarks) const;
  Eigen::Vector2d centreOf(const Sheet& sheet) const;
  Eigen::Vector2d centreOf(const Sheet& sheet, const TilePlace& tile) const;
  void forgetEmptySheets();
  std::size_t drop(double bytes, const Eigen::Vector2d& vehicle);

  CellPart movingPart(const CellStore& tile, int layer, int index) const;

  // Settling (waiting_settling.cpp).
  struct SettlingTile;
  std::vector<SettlingTile> tilesWithin(const std::vector<Box>& boxes, Sheet& sheet);
  void makeRoom(const SettlingTile& tile, int layer, Taker& taker);
  void settleLayer(SettlingTile& tile, int layer, Taker& taker);

  // Joining (waiting_joins.cpp).
  using SheetPair = std::pair<std::uint64_t, std::uint64_t>;  ///< ids, ascending
  /// How two sheets were joined last.
  struct Joined {
    using Places = Eigen::Matrix<double, 2, 4>;
    std::uint64_t revision = 0;  ///< 0: they were not
    /// The middles between the anchors of the one and of the other, in each sheet [m]: how they lay
    /// to each other, and where the line between them was.
    Places middles = Places::Zero();

    template <class Archive>
    void describeState(Archive& archive) {
      archive(revision, middles);
    }
  };
  Eigen::Vector2d anchorMiddle(const Sheet& sheet, const LandmarkPlaces& landmarks) const;
  Box boxOf(const Sheet& sheet) const;
  /// A sheet that is not being written, and whose anchors are there.
  struct Joinable {
    Sheet* sheet;
    std::array<int, 2> anchors;  ///< as they are called now
    Eigen::Vector2d middle;      ///< between them, in map
    Box box;                     ///< of its tiles, in map
  };
  std::vector<Joinable> joinableSheets(const LandmarkPlaces& landmarks);
  bool mayHaveToJoin(const Joinable& a, const Joinable& b) const;
  void joinPair(const Joinable& a, const Joinable& b, std::uint64_t revision);
  class CellMove;

  WaitingConfig config_;
  const LayerSet& layers_;
  double resolution_m_;
  std::vector<Sheet> sheets_;
  std::size_t selected_ = 0;
  std::map<SheetPair, Joined> joined_;
  std::uint64_t sheets_made_ = 0;
  Pose2 T_cells_map_;  ///< of the selected sheet
  CellStore* last_tile_ = nullptr;
  TilePlace last_place_{};
};

}  // namespace hymm::core
