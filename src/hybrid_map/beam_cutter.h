#pragma once

#include <vector>

#include <Eigen/Core>

#include "hybrid_map/ltr_mesh.h"

namespace hymm::core {

/// A part of a beam inside one LTR, or outside all of them. Places on the beam are shares of its
/// length, 0 at its start and 1 at its end.
struct BeamPiece {
  int ltr = kNone;
  double from = 0.0;
  double to = 0.0;
  /// Where the whole beam starts, and how far it leads: local coordinates of the LTR (3), or metres
  /// in map where there is none.
  Eigen::Vector2d start = Eigen::Vector2d::Zero(), along = Eigen::Vector2d::Zero();

  Eigen::Vector2d at(double share) const { return start + share * along; }
};

/// Cuts beams at the sides of LTRs that they cross. The pieces follow one another from 0 to 1
/// without gaps; an affine map keeps a straight line straight, so each piece is straight in the
/// local coordinates of its LTR.
class BeamCutter {
 public:
  explicit BeamCutter(const LtrMesh& mesh) : mesh_(mesh) {}

  /// Appends the pieces of the beam between two places in map, in order, one at least.
  void cut(const Eigen::Vector2d& start, const Eigen::Vector2d& end,
           std::vector<BeamPiece>& pieces);

 private:
  struct Crossing {
    int ltr = kNone;
    int side = kNone;
    double at = 1.0;
  };

  BeamPiece wholeBeamIn(int ltr) const;
  Crossing leaveOf(const BeamPiece& beam, int entered_side) const;
  Crossing nextEntry(double from, int left_ltr) const;
  Crossing missedEntry(double from, double to) const;

  const LtrMesh& mesh_;
  Eigen::Vector2d start_ = Eigen::Vector2d::Zero(), end_ = Eigen::Vector2d::Zero();
  int hint_ = kNone;
};

}  // namespace hymm::core
