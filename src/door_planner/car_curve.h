#pragma once

#include <vector>

#include "common/pose2.h"

namespace hymm::core {

/// A stretch of a way that a car drives with its steering held.
struct CurvePiece {
  double curvature = 0.0;  ///< 1/m, positive to the left
  double length_m = 0.0;   ///< negative: backwards
};

/// A pose on a way, and how it is driven to.
struct CarPose {
  Pose2 T_map_base;
  bool is_backwards = false;
};

/// Where a car is after a piece.
Pose2 advance(const Pose2& T_map_base, const CurvePiece& piece);

/// Arcs and straight lines in a row, as the shortest ways of a car are made of.
struct CarCurve {
  Pose2 start, end;
  std::vector<CurvePiece> pieces;

  double length() const;
  int directionChanges() const;
  /// The ends of all pieces, and poses between them at most `step_m` apart; not the start. The last
  /// is the end, without what rounding adds up to.
  std::vector<CarPose> poses(double step_m) const;
};

}  // namespace hymm::core
