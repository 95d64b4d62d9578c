#pragma once

#include <array>
#include <limits>
#include <memory>
#include <vector>

#include "information_map/information_evaluator.h"
#include "information_map/level_lattice.h"

namespace hymm::core {

/// An evaluation of i(X) at a cell, and how long it holds.
struct Certificate {
  static constexpr float kUnlimited = std::numeric_limits<float>::infinity();

  float value = 0.0F;     ///< i(X) [1/m^2]
  float slack = 0.0F;     ///< least change of log i that changes the cell's level
  float margin_m = 0.0F;  ///< least motion of landmarks that changes the visible set
  float moved_at = 0.0F, changed_at = 0.0F;  ///< the tile's sums when it was made
  int landmarks = -1;                        ///< it comes from; -1: there is no evaluation
  bool is_summit = false;                    ///< a climb from a landmark ended here
};

/// The evaluations that level sets rest on. What landmarks around a tile do is added up for the
/// tile; an evaluation holds until the sum has grown by more than what it can bear.
class CertificateStore {
 public:
  /// Changes of what the landmarks in reach of a tile are.
  struct Tile {
    std::array<Certificate, LevelLattice::kTileCells> certificates;
    float moved_m = 0.0F;     ///< sum of motions
    float changed = 0.0F;     ///< sum of changes of log i, as sampled
    float unsampled = 0.0F;   ///< change of landmarks since `changed` was sampled
    float settled_at = 0.0F;  ///< of moved_m, when losses were last let go
    bool is_touched = false;  ///< by the last change of the map
    bool is_dirty = true;     ///< levels in or beside it changed since its borders were looked over
    bool lets_go = false;     ///< of kept losses, since landmarks moved by a cell
  };

  /// `least_margin_m` is granted where an evaluation knows no margin.
  explicit CertificateStore(float least_margin_m) : least_margin_m_(least_margin_m) {}

  /// Makes room for the tiles of a lattice.
  void resize(int tiles);
  int size() const { return static_cast<int>(tiles_.size()); }
  Tile& tile(int index) { return *tiles_[std::size_t(index)]; }
  const Tile& tile(int index) const { return *tiles_[std::size_t(index)]; }

  /// Keeps an evaluation whose log may change by `slack` without consequence.
  void certify(int tile, int cell, const AchievableInformation& information, double slack);

  bool holds(int tile, int cell) const {
    const Tile& held = this->tile(tile);
    const Certificate& certificate = held.certificates[std::size_t(cell)];
    return certificate.landmarks >= 0 &&
           held.moved_m - certificate.moved_at <= certificate.margin_m &&
           held.changed - certificate.changed_at <= certificate.slack;
  }

  /// A new change of the map begins. Losses kept are let go after a motion of `let_go_m`.
  void beginChange(float let_go_m);
  /// Landmarks in reach of a tile moved and changed by at most so much.
  void addChange(int tile, float moved_m, float changed);
  /// The sample at `cell`, evaluated anew, tells by how much log i changed in the tile: `before`
  /// was its certificate. False if it cannot tell, since it sees other landmarks now.
  bool addSample(int tile, int cell, const Certificate& before);
  void revokeAll(int tile);

  static constexpr int kMostSamples = 3;
  /// Cells whose level is nearest to changing, the nearest first; -1 for none.
  std::array<int, kMostSamples> tightest(int tile) const;

 private:
  float least_margin_m_;
  std::vector<std::unique_ptr<Tile>> tiles_;
};

}  // namespace hymm::core
