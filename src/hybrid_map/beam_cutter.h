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
};

/// Cuts beams at the sides of LTRs that they cross. The pieces follow one another from 0 to 1
/// without gaps; an affine map keeps a straight line straight, so each piece is straight in the
/// local coordinates of its LTR.
class BeamCutter {
 public:
  explicit BeamCutter(const LtrMesh& mesh) : mesh_(mesh) {}

  /// Pieces of the beam between two places in map, in order; valid until the next call.
  const std::vector<BeamPiece>& cut(const Eigen::Vector2d& start, const Eigen::Vector2d& end);

 private:
  struct Crossing {
    int ltr = kNone;
    int side = kNone;
    double at = 1.0;
  };

  void addPiece(int ltr, double from, double to);
  Crossing leaveOf(int ltr, int entered_side) const;
  Crossing nextEntry(double from, int left_ltr) const;
  Crossing missedEntry(double from, double to) const;

  const LtrMesh& mesh_;
  Eigen::Vector2d start_ = Eigen::Vector2d::Zero(), end_ = Eigen::Vector2d::Zero();
  std::vector<BeamPiece> pieces_;
  int hint_ = kNone;
};

}  // namespace hymm::core
